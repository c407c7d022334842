/* What the board does for the program. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* Prints a text on the debugger's channel. */
void say(const char *text);

/* Ends the run. */
void leave(uint32_t code) __attribute__((noreturn));

/* Bytes of the stack that were in use at the deepest moment so far. */
uint32_t stack_bytes(void);

/* The program; whether all went well. */
int press(void);

#endif
