/* Presses for a second and prints a force for each millisecond: the program of host/SIMULATOR.md, in C and C++. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <time.h>
#include "chaincell_client.h"

int main(int count, char **words)
{
    const char *scene = count > 1 ? words[1] : "left";
    const struct timespec millisecond = {0, 1000000};
    chaincell_client client;
    chaincell_client_answer answer;
    chaincell_tool_pose pose = {{0, 0, 0.08f}, {0, 0, 0, 1}, 0, 0}; /* position [m], quaternion, engaged, opening */
    const chaincell_client_code code = chaincell_client_open(CHAINCELL_CLIENT_VERSION, scene, NULL, &client);
    int tick;

    if (code < 0) {
        return puts(chaincell_client_error_text(code));
    }
    for (tick = 0; tick < 1000 && chaincell_client_step(client, &pose, 1, 900000, &answer) >= 0; tick++) {
        printf("%g N\n", answer.tools[0].force_n[2]);
        pose.engaged = 1;               /* it was released once: now it takes hold */
        pose.position_m[2] -= 0.00004f; /* 40 mm down in 1000 poses */
        nanosleep(&millisecond, NULL);  /* a device's loop has a clock of its own */
    }
    return chaincell_client_close(client);
}
