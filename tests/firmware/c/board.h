/* What the board does for the program. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* Prints a text on the debugger's channel. */
void say(const char *text);

/* Ends the run. */
void leave(uint32_t code) __attribute__((noreturn));

/* The program; whether all went well. */
int press(void);

#endif
