#ifndef QUEUE_H
#define QUEUE_H

#include "FreeRTOS.h"

QueueHandle_t xQueueGenericCreateStatic(const UBaseType_t length, const UBaseType_t size, uint8_t *storage,
                                        StaticQueue_t *memory, const uint8_t kind);
#define xQueueCreateStatic(length, size, storage, memory) \
    xQueueGenericCreateStatic((length), (size), (storage), (memory), 0U)
BaseType_t xQueueGenericSend(QueueHandle_t queue, const void *item, TickType_t ticks, BaseType_t position);
#define xQueueSend(queue, item, ticks) xQueueGenericSend((queue), (item), (ticks), 0)
BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t ticks);

#endif
