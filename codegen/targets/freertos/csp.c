/* The runtime of csp.h: the board, the commit of an event, and the body of every task. */
#include "csp.h"

typedef struct {
    TaskHandle_t handle;
    StaticTask_t control;
    csp_index_t state;   /* while it waits: the state whose events it offers */
    csp_event_t taken;   /* the event that was chosen for it; CSP_NONE: none yet */
    csp_index_t next;    /* the state behind that */
    uint32_t tocks;      /* how many clocked events it has performed */
    uint32_t releases;   /* how many releases it has had */
} csp_party_t;

/* An event that is possible: what it is, who performs it, and what it comes after. */
typedef struct {
    csp_event_t event;
    uint32_t group;
    uint8_t rank;
} csp_commit_t;

static const csp_program_t *program;
static csp_party_t parties[CSP_MOST_TASKS];
static StaticSemaphore_t lock_memory;
static SemaphoreHandle_t lock;
static uint32_t waiting; /* the tasks that are on the board, a bit each */
static uint32_t alive;
static uint32_t happened;
static uint32_t random_state = 2463534242U;

void csp_seed(uint32_t seed)
{
    random_state = (seed == 0U) ? 2463534242U : seed;
}

uint32_t csp_decide(uint32_t count)
{
    configASSERT(count != 0U);
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state % count;
}

uint32_t csp_events(void)
{
    return happened;
}

static uint32_t bit(uint16_t task)
{
    return (uint32_t)1U << task;
}

static const csp_state_t *state_of(uint16_t task)
{
    return &program->tasks[task].machine->states[parties[task].state];
}

/* From which tick on a task offers the events of a channel; 0: at once. */
static TickType_t due(uint16_t task, uint16_t channel)
{
    const csp_task_t *one = &program->tasks[task];
    const csp_party_t *party = &parties[task];
    if (program->channels[channel].clocked) {
        return pdMS_TO_TICKS((party->tocks + 1U) * program->tock_ms);
    }
    if (one->timed_channel == channel) {
        return pdMS_TO_TICKS(one->offset_ms + (party->releases * one->period_ms));
    }
    return 0U;
}

/* The position of the first move of a waiting task with this event; moves of its state if there is none. */
static csp_index_t find(uint16_t task, csp_event_t event)
{
    const csp_state_t *state = state_of(task);
    const csp_move_t *moves = &program->tasks[task].machine->moves[state->first_move];
    csp_index_t low = 0U;
    csp_index_t high = state->moves;
    while (low < high) {
        const csp_index_t middle = (csp_index_t)(low + ((high - low) / 2U));
        if (moves[middle].event < event) {
            low = (csp_index_t)(middle + 1U);
        } else {
            high = middle;
        }
    }
    return ((low < state->moves) && (moves[low].event == event)) ? low : state->moves;
}

/* Whether all tasks of a group but one, which does, offer an event now. */
static bool all_offer(uint32_t group, uint16_t but, csp_event_t event, TickType_t now)
{
    const uint16_t channel = program->channel_of[event];
    for (uint16_t task = 0U; task < program->task_count; task++) {
        if (((group & bit(task)) != 0U) && (task != but)) {
            if ((due(task, channel) > now) || (find(task, event) == state_of(task)->moves)) {
                return false;
            }
        }
    }
    return true;
}

/* One of the events that are possible for a task, those of the first rank; whether there is one. Which of several is
 * looked at first goes round, so that none is left out for ever. */
static bool possible(uint16_t task, TickType_t now, csp_commit_t *commit)
{
    const csp_state_t *state = state_of(task);
    const csp_move_t *moves = &program->tasks[task].machine->moves[state->first_move];
    const csp_index_t count = state->moves;
    bool found = false;
    csp_index_t at = (count > 1U) ? (csp_index_t)csp_decide(count) : 0U;
    for (csp_index_t step = 0U; step < count; step++) {
        const csp_event_t event = moves[at].event;
        const uint16_t channel = program->channel_of[event];
        const uint8_t rank = program->channels[channel].rank;
        if ((!found || (rank < commit->rank)) && (due(task, channel) <= now)) {
            const csp_groups_t groups = program->groups[event];
            for (uint16_t g = 0U; g < groups.count; g++) {
                const uint32_t group = program->members[groups.first + g];
                if (((group & bit(task)) != 0U) && ((group & waiting) == group)
                    && all_offer(group, task, event, now)) {
                    commit->event = event;
                    commit->group = group;
                    commit->rank = rank;
                    found = true;
                    break;
                }
            }
        }
        if (found && (commit->rank == 0U)) {
            break;
        }
        at = (csp_index_t)((at + 1U < count) ? (at + 1U) : 0U);
    }
    return found;
}

static void record(csp_event_t event, uint32_t group)
{
    happened++;
    csp_on_event(event, group);
}

/* Let a task have an event: the state behind it is one of those that its moves with this event lead to. */
static void take(uint16_t task, csp_event_t event)
{
    const csp_state_t *state = state_of(task);
    const csp_move_t *moves = &program->tasks[task].machine->moves[state->first_move];
    const csp_index_t first = find(task, event);
    csp_index_t count = 1U;
    configASSERT(first < state->moves);
    while ((first + count < state->moves) && (moves[first + count].event == event)) {
        count++;
    }
    parties[task].next = moves[first + ((count > 1U) ? csp_decide(count) : 0U)].next;
    parties[task].taken = event;
    waiting &= ~bit(task);
}

static csp_method_t method_of(uint16_t task, csp_event_t event)
{
    const csp_method_t *methods = program->tasks[task].methods;
    return (methods == NULL) ? NULL : methods[program->channel_of[event]];
}

/* The queue that a waiting task sends to or receives from; NULL if there is none. */
static const csp_queue_t *queue_of(uint16_t task)
{
    const csp_state_t *state = state_of(task);
    csp_index_t number = CSP_NONE;
    if (state->moves > 0U) {
        const csp_event_t event = program->tasks[task].machine->moves[state->first_move].event;
        number = program->channels[program->channel_of[event]].queue;
    }
    return (number == CSP_NONE) ? NULL : &program->queues[number];
}

/* A waiting task sends, or receives, if there is room, or something; whether it did. Nothing waits in the kernel's queue. */
static bool pass(uint16_t task, const csp_queue_t *queue)
{
    csp_event_t event;
    if (task == queue->sender) {
        event = program->tasks[task].machine->moves[state_of(task)->first_move].event;
        if (xQueueSend(*queue->handle, &event, 0U) != pdTRUE) {
            return false;
        }
    } else {
        if (xQueueReceive(*queue->handle, &event, 0U) != pdTRUE) {
            return false;
        }
        record(event, bit(queue->sender) | bit(queue->receiver));
    }
    take(task, event);
    return true;
}

/* The same, and then the other side, if that waits for it. */
static bool pass_on(uint16_t task, const csp_queue_t *queue)
{
    const uint16_t other = (task == queue->sender) ? queue->receiver : queue->sender;
    const bool done = pass(task, queue);
    if (done && ((waiting & bit(other)) != 0U) && (queue_of(other) == queue) && pass(other, queue)) {
        (void)xTaskNotifyGive(parties[other].handle);
    }
    return done;
}

/* Try to let an event happen in which a task takes part; whether one did. */
static bool commit_for(uint16_t task)
{
    csp_commit_t commit = {CSP_NONE, 0U, 0U};
    const csp_queue_t *queue = queue_of(task);
    if (queue != NULL) {
        return pass_on(task, queue);
    }
    if (!possible(task, xTaskGetTickCount(), &commit)) {
        return false;
    }
    if (method_of(task, commit.event) == NULL) {
        record(commit.event, commit.group);
    }
    for (uint16_t other = 0U; other < program->task_count; other++) {
        if ((commit.group & bit(other)) != 0U) {
            take(other, commit.event);
            if (other != task) {
                (void)xTaskNotifyGive(parties[other].handle);
            }
        }
    }
    return true;
}

/* How long a waiting task may sleep before something that it offers begins to stand. */
static TickType_t patience(uint16_t task, TickType_t now)
{
    const csp_state_t *state = state_of(task);
    const csp_move_t *moves = &program->tasks[task].machine->moves[state->first_move];
    TickType_t least = portMAX_DELAY;
    for (csp_index_t i = 0U; i < state->moves; i++) {
        const TickType_t from = due(task, program->channel_of[moves[i].event]);
        if ((from > now) && ((from - now) < least)) {
            least = from - now;
        }
    }
    return least;
}

/* Whether nothing is possible, now or later: every task that lives waits, and for no time. Under the mutex. */
static bool stuck(void)
{
    if ((waiting != alive) || (alive == 0U)) {
        return false;
    }
    for (uint16_t task = 0U; task < program->task_count; task++) {
        if (((alive & bit(task)) != 0U) && (patience(task, xTaskGetTickCount()) != portMAX_DELAY)) {
            return false;
        }
    }
    return true;
}

/* Wait until one of the events of a state has happened; the state behind it. */
static csp_index_t wait_in(uint16_t task, csp_index_t state)
{
    csp_party_t *party = &parties[task];
    bool done;
    TickType_t ticks = portMAX_DELAY;
    (void)xSemaphoreTake(lock, portMAX_DELAY);
    party->state = state;
    party->taken = CSP_NONE;
    waiting |= bit(task);
    done = commit_for(task);
    if (!done) {
        ticks = patience(task, xTaskGetTickCount());
        if (stuck()) {
            csp_on_deadlock();
        }
    }
    (void)xSemaphoreGive(lock);
    while (!done) {
        (void)ulTaskNotifyTake(pdTRUE, ticks);
        (void)xSemaphoreTake(lock, portMAX_DELAY);
        done = (party->taken != CSP_NONE);
        if (!done) {
            done = commit_for(task);
            ticks = patience(task, xTaskGetTickCount());
            if (!done && stuck()) {
                csp_on_deadlock();
            }
        }
        (void)xSemaphoreGive(lock);
    }
    return party->next;
}

/* What a task does by itself: its method says which of the events that it offered it has performed. */
static csp_index_t perform(uint16_t task, csp_index_t state, csp_method_t method)
{
    csp_party_t *party = &parties[task];
    const csp_event_t event = method(party->taken);
    csp_index_t next;
    (void)xSemaphoreTake(lock, portMAX_DELAY);
    party->state = state;
    take(task, event); /* asserts that the event was offered */
    next = party->next;
    record(event, bit(task));
    (void)xSemaphoreGive(lock);
    return next;
}

static void body(void *argument)
{
    const uint16_t task = (uint16_t)(uintptr_t)argument;
    const csp_task_t *one = &program->tasks[task];
    csp_party_t *party = &parties[task];
    csp_index_t state = one->start;
    for (;;) {
        const csp_state_t *row = &one->machine->states[state];
        if (row->ways > 0U) {
            uint32_t way = 0U;
            if (row->ways > 1U) {
                (void)xSemaphoreTake(lock, portMAX_DELAY);
                way = csp_decide(row->ways);
                (void)xSemaphoreGive(lock);
            }
            state = one->machine->ways[row->first_way + way];
        } else if (row->ends) {
            bool last;
            (void)xSemaphoreTake(lock, portMAX_DELAY);
            alive &= ~bit(task);
            last = (alive == 0U);
            if (last) {
                csp_on_end();
            } else if (stuck()) {
                csp_on_deadlock();
            } else {
                /* the others go on */
            }
            (void)xSemaphoreGive(lock);
            vTaskSuspend(NULL);
        } else {
            const csp_index_t before = state;
            csp_method_t method;
            state = wait_in(task, before);
            method = method_of(task, party->taken);
            if (method != NULL) {
                state = perform(task, before, method);
            }
            if (program->channels[program->channel_of[party->taken]].clocked) {
                party->tocks++;
            }
            if (program->channel_of[party->taken] == one->timed_channel) {
                party->releases++;
            }
        }
    }
}

void csp_create(const csp_program_t *of)
{
    configASSERT(of->task_count <= CSP_MOST_TASKS);
    program = of;
    lock = xSemaphoreCreateMutexStatic(&lock_memory);
    for (uint16_t i = 0U; i < of->queue_count; i++) {
        const csp_queue_t *queue = &of->queues[i];
        *queue->handle = xQueueCreateStatic(queue->length, sizeof(csp_event_t), queue->storage, queue->control);
        configASSERT(*queue->handle != NULL);
    }
    for (uint16_t task = 0U; task < of->task_count; task++) {
        alive |= bit(task);
    }
    for (uint16_t task = 0U; task < of->task_count; task++) {
        const csp_task_t *one = &of->tasks[task];
        parties[task].taken = CSP_NONE;
        parties[task].handle = xTaskCreateStatic(body, one->name, one->stack_words, (void *)(uintptr_t)task,
                                                 one->priority, one->stack, &parties[task].control);
        configASSERT(parties[task].handle != NULL);
    }
}
