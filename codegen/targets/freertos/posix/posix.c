/* See FreeRTOS.h. One mutex guards who sleeps, who is told, and what time it is. */
#include "semphr.h"
#include "task.h"

static pthread_mutex_t guard = PTHREAD_MUTEX_INITIALIZER;
static pthread_key_t self;
static StaticTask_t *tasks;
static unsigned awake;
static TickType_t now;

SemaphoreHandle_t xSemaphoreCreateMutexStatic(StaticSemaphore_t *memory)
{
    (void)pthread_mutex_init(&memory->mutex, NULL);
    return memory;
}

BaseType_t xSemaphoreTake(SemaphoreHandle_t mutex, TickType_t ticks)
{
    (void)ticks;
    return (pthread_mutex_lock(&mutex->mutex) == 0) ? pdTRUE : pdFALSE;
}

BaseType_t xSemaphoreGive(SemaphoreHandle_t mutex)
{
    return (pthread_mutex_unlock(&mutex->mutex) == 0) ? pdTRUE : pdFALSE;
}

static void *carry(void *argument)
{
    StaticTask_t *task = argument;
    (void)pthread_setspecific(self, task);
    task->body(task->argument);
    return NULL;
}

TaskHandle_t xTaskCreateStatic(void (*body)(void *argument), const char *name, uint32_t stack_words, void *argument,
                               UBaseType_t priority, StackType_t *stack, StaticTask_t *memory)
{
    (void)name;
    (void)stack_words;
    (void)priority;
    (void)stack;
    (void)pthread_cond_init(&memory->told, NULL);
    memory->body = body;
    memory->argument = argument;
    memory->others = tasks;
    tasks = memory;
    return memory;
}

void vTaskStartScheduler(void)
{
    (void)pthread_key_create(&self, NULL);
    for (StaticTask_t *task = tasks; task != NULL; task = task->others) {
        awake++;
    }
    for (StaticTask_t *task = tasks; task != NULL; task = task->others) {
        configASSERT(pthread_create(&task->thread, NULL, carry, task) == 0);
    }
    for (StaticTask_t *task = tasks; task != NULL; task = task->others) {
        (void)pthread_join(task->thread, NULL);
    }
}

/* When all sleep, time goes on to when the first of them wants to be woken. Under the guard. */
static void pass_time(void)
{
    TickType_t first = portMAX_DELAY;
    if (awake > 0U) {
        return;
    }
    for (StaticTask_t *task = tasks; task != NULL; task = task->others) {
        if (task->sleeping && (task->until < first)) {
            first = task->until;
        }
    }
    if (first == portMAX_DELAY) {
        return;
    }
    now = first;
    for (StaticTask_t *task = tasks; task != NULL; task = task->others) {
        if (task->sleeping && (task->until <= now)) {
            task->sleeping = false;
            awake++;
            (void)pthread_cond_signal(&task->told);
        }
    }
}

void vTaskSuspend(TaskHandle_t task)
{
    StaticTask_t *own = (task == NULL) ? pthread_getspecific(self) : task;
    (void)pthread_mutex_lock(&guard);
    awake--;
    own->sleeping = true;
    own->until = portMAX_DELAY;
    pass_time();
    (void)pthread_mutex_unlock(&guard);
    pthread_exit(NULL);
}

BaseType_t xTaskNotifyGive(TaskHandle_t task)
{
    (void)pthread_mutex_lock(&guard);
    task->notified++;
    if (task->sleeping) {
        task->sleeping = false;
        awake++;
        (void)pthread_cond_signal(&task->told);
    }
    (void)pthread_mutex_unlock(&guard);
    return pdPASS;
}

uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks)
{
    StaticTask_t *own = pthread_getspecific(self);
    uint32_t found;
    (void)pthread_mutex_lock(&guard);
    if (own->notified == 0U) {
        own->until = (ticks == portMAX_DELAY) ? portMAX_DELAY : (now + ticks);
        own->sleeping = true;
        awake--;
        pass_time();
        while (own->sleeping) {
            (void)pthread_cond_wait(&own->told, &guard);
        }
    }
    found = own->notified;
    own->notified = (clear == pdTRUE) ? 0U : ((found > 0U) ? (found - 1U) : 0U);
    (void)pthread_mutex_unlock(&guard);
    return found;
}

TickType_t xTaskGetTickCount(void)
{
    TickType_t time;
    (void)pthread_mutex_lock(&guard);
    time = now;
    (void)pthread_mutex_unlock(&guard);
    return time;
}
