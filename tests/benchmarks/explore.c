/* The yardstick: a straightforward explicit-state exploration in C. States are packed 64-bit integers, rules are
 * (mask, value, xor) triples that are all tried on each state, the visited set is an open-addressing table of
 * states with linear probing, the queue is the array of states in the order of discovery.
 *
 * Input: the number of rules, the initial state, then mask, value, xor of each rule, in decimal.
 * Output: states, transitions, seconds of processor time. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct { uint64_t mask, value, flip; } rule;

static const uint64_t EMPTY = UINT64_MAX;

static size_t place_of(const uint64_t *table, uint64_t capacity, uint64_t state)
{
    uint64_t h = state * 0x9E3779B97F4A7C15u;
    size_t place = (h ^ (h >> 32)) & (capacity - 1);
    while (table[place] != EMPTY && table[place] != state)
        place = (place + 1) & (capacity - 1);
    return place;
}

int main(void)
{
    unsigned rules;
    uint64_t initial;
    if (scanf("%u %lu", &rules, &initial) != 2)
        return 2;
    rule *rule_table = malloc(rules * sizeof *rule_table);
    for (unsigned i = 0; i < rules; i++)
        if (scanf("%lu %lu %lu", &rule_table[i].mask, &rule_table[i].value, &rule_table[i].flip) != 3)
            return 2;

    clock_t start = clock();
    uint64_t capacity = 1024, room = 1024, known = 0, transitions = 0;
    uint64_t *table = malloc(capacity * sizeof *table), *states = malloc(room * sizeof *states);
    memset(table, 0xff, capacity * sizeof *table);
    table[place_of(table, capacity, initial)] = initial;
    states[known++] = initial;
    for (uint64_t next = 0; next < known; next++) {
        uint64_t state = states[next];
        for (unsigned i = 0; i < rules; i++) {
            if ((state & rule_table[i].mask) != rule_table[i].value)
                continue;
            transitions++;
            uint64_t successor = state ^ rule_table[i].flip;
            size_t place = place_of(table, capacity, successor);
            if (table[place] == successor)
                continue;
            table[place] = successor;
            if (known == room)
                states = realloc(states, (room *= 2) * sizeof *states);
            states[known++] = successor;
            if (known * 2 > capacity) {
                free(table);
                capacity *= 2;
                table = malloc(capacity * sizeof *table);
                memset(table, 0xff, capacity * sizeof *table);
                for (uint64_t i2 = 0; i2 < known; i2++)
                    table[place_of(table, capacity, states[i2])] = states[i2];
            }
        }
    }
    printf("%lu %lu %.6f\n", known, transitions, (double)(clock() - start) / CLOCKS_PER_SEC);
    return 0;
}
