/* See FreeRTOS.h. One mutex guards who sleeps, who is told, and what time it is. */
#ifdef __linux__
#define _GNU_SOURCE /* sched_setaffinity */
#else
#define _POSIX_C_SOURCE 200809L
#endif
#include <sched.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>

#include "queue.h"
#include "semphr.h"
#include "task.h"

/* How often a task looks whether it has been told, before it sleeps: to put a thread to sleep and to wake it takes
 * longer than most of those do that it waits for. Between looks the processor is theirs, if they want it. If another
 * program has had it meanwhile, the task sleeps at once for some time. */
#define LOOKS 20
#define TOO_LONG 700000 /* nanoseconds */
#define PENALTY 200U

#define MOST_TOLD 8U

static pthread_mutex_t guard = PTHREAD_MUTEX_INITIALIZER;
static pthread_key_t self;
static StaticTask_t *tasks;
static unsigned awake;
static _Atomic TickType_t now;

/* Of each thread: how many semaphores it has taken, and whom it has told meanwhile. They are woken when it has given
 * them back: else they would wake, wait for the semaphore, and wake again. */
static _Thread_local unsigned held;
static _Thread_local unsigned told_count;
static _Thread_local StaticTask_t *told[MOST_TOLD];

SemaphoreHandle_t xSemaphoreCreateMutexStatic(StaticSemaphore_t *memory)
{
    (void)pthread_mutex_init(&memory->mutex, NULL);
    return memory;
}

BaseType_t xSemaphoreTake(SemaphoreHandle_t mutex, TickType_t ticks)
{
    (void)ticks;
    if (pthread_mutex_lock(&mutex->mutex) != 0) {
        return pdFALSE;
    }
    held++;
    return pdTRUE;
}

BaseType_t xSemaphoreGive(SemaphoreHandle_t mutex)
{
    if (pthread_mutex_unlock(&mutex->mutex) != 0) {
        return pdFALSE;
    }
    held--;
    while ((held == 0U) && (told_count > 0U)) {
        told_count--;
        (void)pthread_cond_signal(&told[told_count]->told);
    }
    return pdTRUE;
}

QueueHandle_t xQueueCreateStatic(UBaseType_t length, UBaseType_t size, uint8_t *storage, StaticQueue_t *memory)
{
    memory->storage = storage;
    memory->size = size;
    memory->length = length;
    memory->first = 0U;
    memory->count = 0U;
    return memory;
}

BaseType_t xQueueSend(QueueHandle_t queue, const void *item, TickType_t ticks)
{
    (void)ticks;
    if (queue->count == queue->length) {
        return pdFALSE;
    }
    (void)memcpy(&queue->storage[((queue->first + queue->count) % queue->length) * queue->size], item, queue->size);
    queue->count++;
    return pdTRUE;
}

BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t ticks)
{
    (void)ticks;
    if (queue->count == 0U) {
        return pdFALSE;
    }
    (void)memcpy(item, &queue->storage[queue->first * queue->size], queue->size);
    queue->first = (queue->first + 1U) % queue->length;
    queue->count--;
    return pdTRUE;
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

/* A target has one processor, and so have the tasks here, where that can be said: the one that this thread is on. To
 * wake a thread on another one takes several times as long as all the rest of an event, and they wait for one mutex. */
static void one_processor(void)
{
#ifdef __linux__
    const int processor = sched_getcpu();
    cpu_set_t set;
    if (processor >= 0) {
        CPU_ZERO(&set);
        CPU_SET((size_t)processor, &set);
        (void)sched_setaffinity(0, sizeof set, &set);
    }
#endif
}

void vTaskStartScheduler(void)
{
    one_processor();
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
        if ((held > 0U) && (told_count < MOST_TOLD)) {
            told[told_count] = task;
            told_count++;
        } else {
            (void)pthread_cond_signal(&task->told);
        }
    }
    (void)pthread_mutex_unlock(&guard);
    return pdPASS;
}

/* Under the guard, which it lets go for a moment. */
static void look(StaticTask_t *own)
{
    if (own->at_once > 0U) {
        own->at_once--;
        return;
    }
    for (int count = 0; (count < LOOKS) && (own->notified == 0U) && (own->at_once == 0U); count++) {
        struct timespec before;
        struct timespec after;
        (void)pthread_mutex_unlock(&guard);
        (void)clock_gettime(CLOCK_MONOTONIC, &before);
        (void)sched_yield();
        (void)clock_gettime(CLOCK_MONOTONIC, &after);
        (void)pthread_mutex_lock(&guard);
        if (((int64_t)(after.tv_sec - before.tv_sec) * 1000000000) + (after.tv_nsec - before.tv_nsec) > TOO_LONG) {
            own->at_once = PENALTY;
        }
    }
}

uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks)
{
    StaticTask_t *own = pthread_getspecific(self);
    uint32_t found;
    (void)pthread_mutex_lock(&guard);
    look(own);
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
    return atomic_load(&now);
}
