/* Processes that synchronise on events, on FreeRTOS: one task a process, static memory only.
 *
 * Every task is a machine: a table of states, with the events that it offers in each. A task that waits has put its
 * state on a board; under one mutex exactly one event that all tasks of one of its groups offer is chosen for all of
 * them at once, and each is notified. That is the commit protocol of specs/channels/commit.csp, checked to be external
 * choice; nothing is ever taken half. Channels that were asked for and shown to be as good are queues.
 */
#ifndef CSP_H
#define CSP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "FreeRTOS.h"
#include "queue.h"
#include "semphr.h"
#include "task.h"

#define CSP_MOST_TASKS 32U /* a group of tasks is a word */
#define CSP_NONE 0xFFFFU

typedef uint16_t csp_event_t;
typedef uint16_t csp_index_t;

/* An event that a state offers, and the state behind it. The moves of a state are sorted by event. */
typedef struct {
    csp_event_t event;
    csp_index_t next;
} csp_move_t;

/* A state: its moves, or, if it has ways, the states of which it chooses one by itself. */
typedef struct {
    uint32_t first_move;
    csp_index_t moves;
    csp_index_t ways;
    uint32_t first_way;
    bool ends;
} csp_state_t;

typedef struct {
    const csp_state_t *states;
    const csp_move_t *moves;
    const csp_index_t *ways;
} csp_machine_t;

/* What a task does when it performs an event of a channel alone: it is told one of the events that it offers, and says
 * which of them it has performed. */
typedef csp_event_t (*csp_method_t)(csp_event_t offered);

/* A channel: its events are numbered from `first`. `rank`: priorities; the lower comes first. `clocked`: an event of it
 * happens every `csp_tock_ticks`, when nothing of a lower rank is possible. */
typedef struct {
    csp_event_t first;
    csp_event_t count;
    uint8_t rank;
    bool clocked;
    bool hidden;
    csp_index_t queue; /* CSP_NONE: it is none */
} csp_channel_t;

/* The groups of tasks that can perform an event: `count` words from `first` on. */
typedef struct {
    uint16_t first;
    uint16_t count;
} csp_groups_t;

typedef struct {
    const char *name;
    const csp_machine_t *machine;
    csp_index_t start;
    const csp_method_t *methods; /* by channel; NULL where it performs nothing alone */
    UBaseType_t priority;
    uint32_t period_ms; /* 0: not periodic */
    uint32_t offset_ms;
    uint16_t timed_channel; /* the channel that waits for its next release; CSP_NONE: none */
    StackType_t *stack;
    uint32_t stack_words;
} csp_task_t;

/* A channel that is a queue of events: its memory, and where its handle is kept. */
typedef struct {
    uint16_t sender;
    uint16_t receiver;
    UBaseType_t length;
    uint8_t *storage;
    StaticQueue_t *control;
    QueueHandle_t *handle;
} csp_queue_t;

typedef struct {
    const csp_task_t *tasks;
    uint16_t task_count;
    const csp_channel_t *channels;
    const uint16_t *channel_of; /* by event */
    const csp_groups_t *groups; /* by event */
    const uint32_t *members;    /* the words of the groups */
    uint32_t tock_ms;
    const csp_queue_t *queues; /* NULL if there is none */
    uint16_t queue_count;
} csp_program_t;

/* Create the tasks of the program. Call once, before vTaskStartScheduler. */
void csp_create(const csp_program_t *program);

/* A number below `count`, which must not be zero: what decides where the specification leaves a choice. */
uint32_t csp_decide(uint32_t count);
void csp_seed(uint32_t seed);

/* Events that have happened so far. */
uint32_t csp_events(void);

/* To be written by the application. */
void csp_on_event(csp_event_t event, uint32_t group); /* under the mutex: be quick */
void csp_on_deadlock(void);                           /* every task waits, for ever */
void csp_on_end(void);                                /* every task has ended */

#endif
