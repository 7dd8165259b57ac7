/* The calls of FreeRTOS that csp.c makes, on pthreads: to run a program on the machine that it was written on.
 *
 * This is not FreeRTOS and not its POSIX port: every task is a thread, whose turn it is the system decides, priorities
 * mean nothing, and time passes only when every task waits (a tick is a millisecond), so an hour of a program takes as
 * long as its events take. On Linux the threads share one processor, as on a target.
 */
#ifndef FREERTOS_H
#define FREERTOS_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef uint32_t TickType_t;
typedef int BaseType_t;
typedef unsigned UBaseType_t;
typedef uint32_t StackType_t;

#define pdTRUE 1
#define pdFALSE 0
#define pdPASS 1
#define portMAX_DELAY 0xFFFFFFFFU
#define tskIDLE_PRIORITY 0U
#define configMINIMAL_STACK_SIZE 128U
#define pdMS_TO_TICKS(ms) ((TickType_t)(ms))
#define configASSERT(condition)                                                             \
    do {                                                                                    \
        if (!(condition)) {                                                                 \
            (void)fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition); \
            exit(3);                                                                        \
        }                                                                                   \
    } while (0)

typedef struct posix_task {
    pthread_t thread;
    pthread_cond_t told;
    uint32_t notified;
    uint32_t at_once; /* how many times more it sleeps without a look */
    bool sleeping;
    TickType_t until;
    struct posix_task *others;
    void (*body)(void *argument);
    void *argument;
} StaticTask_t;
typedef StaticTask_t *TaskHandle_t;

typedef struct {
    pthread_mutex_t mutex;
} StaticSemaphore_t;
typedef StaticSemaphore_t *SemaphoreHandle_t;

typedef struct {
    uint8_t *storage;
    UBaseType_t size;
    UBaseType_t length;
    UBaseType_t first;
    UBaseType_t count;
} StaticQueue_t;
typedef StaticQueue_t *QueueHandle_t;

#endif
