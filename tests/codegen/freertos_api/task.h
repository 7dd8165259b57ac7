#ifndef INC_TASK_H
#define INC_TASK_H

#include "FreeRTOS.h"

typedef void (*TaskFunction_t)(void *);
TaskHandle_t xTaskCreateStatic(TaskFunction_t code, const char *const name, const uint32_t words, void *const argument,
                               UBaseType_t priority, StackType_t *const stack, StaticTask_t *const memory);
void vTaskStartScheduler(void);
void vTaskSuspend(TaskHandle_t task);
BaseType_t xTaskGenericNotify(TaskHandle_t task, UBaseType_t index, uint32_t value, int action, uint32_t *before);
#define xTaskNotifyGive(task) xTaskGenericNotify((task), 0U, 0U, 2, NULL)
uint32_t ulTaskGenericNotifyTake(UBaseType_t index, BaseType_t clear, TickType_t ticks);
#define ulTaskNotifyTake(clear, ticks) ulTaskGenericNotifyTake(0U, (clear), (ticks))
TickType_t xTaskGetTickCount(void);

#endif
