/* A pose of the kernel's header is one of the client's, byte for byte: a tool pose is sent both ways. */
#include "chaincell.h"
#include "chaincell_client.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define SAME(field) \
    (offsetof(chaincell_tool_pose, field) == offsetof(chaincell_client_pose, field) \
     && sizeof ((chaincell_tool_pose *)0)->field == sizeof ((chaincell_client_pose *)0)->field)

int main(void)
{
    /* Half a turn about z, so that each order of the quaternion shows. */
    const chaincell_tool_pose sent = {{1, 2, 3}, {0, 0, 1, 0}, 1};
    chaincell_client_pose between;
    chaincell_tool_pose back;
    if (sizeof sent != sizeof between || !SAME(position_m) || !SAME(orientation) || !SAME(engaged))
        return 1;
    memcpy(&between, &sent, sizeof between);
    memcpy(&back, &between, sizeof back);
    if (memcmp(between.orientation, sent.orientation, sizeof sent.orientation) || back.engaged != 1)
        return 2;
    printf("%g %g %g %g\n", back.orientation[0], back.orientation[1], back.orientation[2],
           back.orientation[3]);
    return 0;
}
