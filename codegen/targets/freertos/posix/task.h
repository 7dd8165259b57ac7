/* Tasks and notifications of FreeRTOS on pthreads: see FreeRTOS.h. */
#ifndef TASK_H
#define TASK_H

#include "FreeRTOS.h"

TaskHandle_t xTaskCreateStatic(void (*body)(void *argument), const char *name, uint32_t stack_words, void *argument,
                               UBaseType_t priority, StackType_t *stack, StaticTask_t *memory);
void vTaskStartScheduler(void);
void vTaskSuspend(TaskHandle_t task);
BaseType_t xTaskNotifyGive(TaskHandle_t task);
uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks);
TickType_t xTaskGetTickCount(void);

#endif
