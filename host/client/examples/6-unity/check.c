/* Prints sizes and offsets as check.cs does. */
#include <stddef.h>
#include <stdio.h>
#include "chaincell_client.h"

#define AT(type, field) printf(" %zu", offsetof(chaincell_##type, field))

int main(void)
{
    printf("version %d\npose %zu", CHAINCELL_CLIENT_VERSION, sizeof(chaincell_tool_pose));
    AT(tool_pose, position_m), AT(tool_pose, orientation), AT(tool_pose, engaged), AT(tool_pose, opening_turns_q16);
    printf("\noutput %zu", sizeof(chaincell_tool_output));
    AT(tool_output, force_n), AT(tool_output, torque_n_m), AT(tool_output, contacts), AT(tool_output, flags);
    printf("\noptions %zu", sizeof(chaincell_client_options));
    AT(client_options, role), AT(client_options, wait), AT(client_options, server_wait_ns);
    AT(client_options, watchdog_ms), AT(client_options, ramp_ms);
    printf("\nanswer %zu", sizeof(chaincell_client_answer));
    AT(client_answer, tick), AT(client_answer, session_id), AT(client_answer, force_tick), AT(client_answer, state_hash);
    AT(client_answer, round_trip_ns), AT(client_answer, age_ns), AT(client_answer, answers), AT(client_answer, energy_j);
    AT(client_answer, flags), AT(client_answer, notes), AT(client_answer, step_ns), AT(client_answer, sweeps);
    AT(client_answer, tools[0]), AT(client_answer, tools[1]), AT(client_answer, force_error_n[0]);
    AT(client_answer, force_error_n[7]), AT(client_answer, torque_error_n_m[0]), AT(client_answer, torque_error_n_m[7]);
    return puts("") < 0;
}
