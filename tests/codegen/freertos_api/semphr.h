#ifndef SEMAPHORE_H
#define SEMAPHORE_H

#include "FreeRTOS.h"
#include "queue.h"

SemaphoreHandle_t xQueueCreateMutexStatic(const uint8_t kind, StaticSemaphore_t *memory);
#define xSemaphoreCreateMutexStatic(memory) xQueueCreateMutexStatic(1U, (memory))
BaseType_t xQueueSemaphoreTake(SemaphoreHandle_t mutex, TickType_t ticks);
#define xSemaphoreTake(mutex, ticks) xQueueSemaphoreTake((mutex), (ticks))
#define xSemaphoreGive(mutex) xQueueGenericSend((mutex), NULL, 0U, 0)

#endif
