/* A tool is one struct for the kernel and for the client: each sends its pose and its output both ways. */
#ifdef CLIENT_FIRST
#include "chaincell_client.h"
#include "chaincell.h"
#else
#include "chaincell.h"
#include "chaincell_client.h"
#endif
#include "chaincell.h"
#include "chaincell_client.h"

#include <stdio.h>

/* What a firmware and a program with the client do with a pose. */
typedef chaincell_code (*tick)(chaincell_tissue *, const chaincell_tool_pose *, size_t,
                               const chaincell_budget *, chaincell_output *);
typedef chaincell_client_code (*send)(chaincell_client, const chaincell_tool_pose *, size_t,
                                      uint64_t *);

static chaincell_tool_pose sent_by_client(const chaincell_tool_pose *pose)
{
    return *pose;
}

int main(void)
{
    /* Half a turn about z, so that each order of the quaternion shows. */
    const chaincell_tool_pose pose = {{1, 2, 3}, {0, 0, 1, 0}, 1, 9};
    const chaincell_tool_pose back = sent_by_client(&pose);
    chaincell_output output = {{{0, 0, 3}, {0, 0.5f, 0}, 7, CHAINCELL_FLAG_LATE}, 0, 0, 0, 4, 0, 0, 0};
    chaincell_client_answer answer = {0};

    answer.tools[1] = output.tool;
    output.tool = answer.tools[1];
    printf("%g %g %g %g, %u, %u, %g N, %g N m, %u, %u\n", (double)back.orientation[0],
           (double)back.orientation[1], (double)back.orientation[2], (double)back.orientation[3],
           (unsigned)back.engaged, (unsigned)back.opening_turns_q16, (double)output.tool.force_n[2],
           (double)output.tool.torque_n_m[1], (unsigned)output.tool.contacts,
           (unsigned)output.tool.flags);
    return sizeof(tick) == sizeof(send) ? 0 : 1;
}
