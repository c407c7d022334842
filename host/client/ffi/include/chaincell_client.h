/*
 * chaincell: soft tissue that a haptic device can feel. The C interface of the client: poses to a running
 * `chaincell serve`, forces back, over shared memory on one machine.
 *
 *   chaincell_client_open     a scene by its name, as its controller or as a viewer
 *   chaincell_client_step     every millisecond: poses of 1 to 8 tools out, forces and torques back
 *   chaincell_client_send, chaincell_client_try_receive    the two apart
 *   chaincell_client_state, chaincell_client_contacts      for viewers, where they lie
 *   chaincell_client_command  pause, resume, reset, set, grip, let go, pin
 *   chaincell_client_pin_at   holds the surface around a place
 *   chaincell_client_close    leaves the scene
 *
 * Every call answers with a chaincell_client_code: 0 when all is well, negative when it was refused;
 * chaincell_client_error_text says it in words. None unwinds. A handle is a number: 0, or one that was closed, is refused.
 *
 * Where answers stay out for the time of the watchdog, the force that is shown falls to 0 along a ramp,
 * and rises along one when they come again. A step of a ramp is a millisecond of it at most, so call at
 * the rate of the device. The force is always finite.
 *
 * One thread at a time may call with a handle; another one gets CHAINCELL_CLIENT_CODE_BUSY at once. A
 * handle for the loop of the device and one as a viewer for the pictures do not hinder each other.
 *
 * Poses, what a tool feels and flags are those of chaincell.h, of which this needs no function.
 *
 * Written from host/client/ffi/src: change it there.
 */

#ifndef CHAINCELL_CLIENT_H
#define CHAINCELL_CLIENT_H

#include <stddef.h>
#include <stdint.h>
#include "chaincell.h"

/* Initialises a chaincell_client_options: how a scene is opened by default, as its controller. */
#define CHAINCELL_CLIENT_OPTIONS_DEFAULT \
    {CHAINCELL_CLIENT_ROLE_CONTROLLER, CHAINCELL_CLIENT_WAIT_HYBRID, UINT64_C(10000000000), 20, 20}

/**
 * No answer has come yet.
 */
#define CHAINCELL_CLIENT_NOTE_NOTHING_YET 1

/**
 * No answer for the time of the watchdog: the force falls, or is 0.
 */
#define CHAINCELL_CLIENT_NOTE_SILENT 2

/**
 * The force is on a ramp, and not yet the force of the tissue.
 */
#define CHAINCELL_CLIENT_NOTE_RAMP 4

/**
 * A new session has answered, of another server: its tissue is at rest, or where `serve --restore` or
 * `serve --stand-by` took it up. Tools get no force until they were released. The note stays until the first
 * answer in which no tool must be released.
 */
#define CHAINCELL_CLIENT_NOTE_NEW_SESSION 8

/**
 * What a call came to: 0 when all is well, above 0 when there is nothing new, negative when it was
 * refused.
 *
 * A number never changes its meaning; `chaincell_client_error_text` says it in words.
 */
enum chaincell_client_code
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done; of a step: the answer to these poses has come.
     */
    CHAINCELL_CLIENT_CODE_OK = 0,
    /**
     * No answer has come, and the watchdog has not bitten: the last force counts.
     */
    CHAINCELL_CLIENT_CODE_NO_ANSWER = 1,
    /**
     * No answer has come for the time of the watchdog: the force falls to 0 along its ramp, or is 0.
     */
    CHAINCELL_CLIENT_CODE_SILENT = 2,
    /**
     * Nothing has come that was not taken yet.
     */
    CHAINCELL_CLIENT_CODE_NOTHING_NEW = 3,
    /**
     * A pointer is null.
     */
    CHAINCELL_CLIENT_CODE_NULL = -1,
    /**
     * A pointer does not have the alignment of what it points to.
     */
    CHAINCELL_CLIENT_CODE_MISALIGNED = -2,
    /**
     * Header and library are of different versions.
     */
    CHAINCELL_CLIENT_CODE_VERSION = -3,
    /**
     * No client has this handle: it was closed, or never opened.
     */
    CHAINCELL_CLIENT_CODE_CLOSED = -4,
    /**
     * Another thread is in a call with this handle.
     */
    CHAINCELL_CLIENT_CODE_BUSY = -5,
    /**
     * The process has as many clients as it can.
     */
    CHAINCELL_CLIENT_CODE_TOO_MANY = -6,
    /**
     * The library has a fault; its handle cannot be used any more, close it.
     */
    CHAINCELL_CLIENT_CODE_FAULT = -7,
    /**
     * A scene name or an option that cannot be.
     */
    CHAINCELL_CLIENT_CODE_ARGUMENT = -8,
    /**
     * No server on the scene.
     */
    CHAINCELL_CLIENT_CODE_NO_SERVER = -20,
    /**
     * The scene speaks messages of another version or make.
     */
    CHAINCELL_CLIENT_CODE_MESSAGES = -21,
    /**
     * Another controller has joined the scene.
     */
    CHAINCELL_CLIENT_CODE_TAKEN = -22,
    /**
     * As many programs as can be have joined already.
     */
    CHAINCELL_CLIENT_CODE_FULL = -23,
    /**
     * The files of shared memory belong to somebody else, or may be written by others.
     */
    CHAINCELL_CLIENT_CODE_PERMISSION = -24,
    /**
     * Shared memory is full.
     */
    CHAINCELL_CLIENT_CODE_MEMORY = -25,
    /**
     * A service of the scene has other limits, or cannot be used.
     */
    CHAINCELL_CLIENT_CODE_SERVICE = -26,
    /**
     * Shared memory failed under way.
     */
    CHAINCELL_CLIENT_CODE_CONNECTION = -27,
    /**
     * A pose that is no pose, or none, or too many: nothing was sent.
     */
    CHAINCELL_CLIENT_CODE_POSE = -40,
    /**
     * The handle is that of a viewer, which has no tools.
     */
    CHAINCELL_CLIENT_CODE_VIEWER = -41,
    /**
     * What was taken last was not released yet.
     */
    CHAINCELL_CLIENT_CODE_HELD = -42,
    /**
     * There is nothing to release.
     */
    CHAINCELL_CLIENT_CODE_NOT_HELD = -43,
    /**
     * No reply to the command in its time: whether it was carried out is not known.
     */
    CHAINCELL_CLIENT_CODE_NO_REPLY = -44,
    /**
     * The server refused the command: nothing has changed.
     */
    CHAINCELL_CLIENT_CODE_REFUSED = -45,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_client_code chaincell_client_code;
#else
typedef int32_t chaincell_client_code;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus


/**
 * Version of this interface: major 65,536, minor 256, patch 1.
 */
#define CHAINCELL_CLIENT_VERSION 1024

/**
 * The body takes its rest shape.
 */
#define CHAINCELL_CLIENT_COMMAND_RESET 1

/**
 * Poses are answered with force 0, and no cell moves.
 */
#define CHAINCELL_CLIENT_COMMAND_PAUSE 2

/**
 * Ends a pause.
 */
#define CHAINCELL_CLIENT_COMMAND_RESUME 3

/**
 * Sets a parameter to the value.
 */
#define CHAINCELL_CLIENT_COMMAND_SET 4

/**
 * The tool that is the parameter takes hold of what it is in contact with.
 */
#define CHAINCELL_CLIENT_COMMAND_GRIP 5

/**
 * The tool that is the parameter lets go within so many ticks as the value says.
 */
#define CHAINCELL_CLIENT_COMMAND_LET_GO 6

/**
 * The session is saved beside its trace.
 */
#define CHAINCELL_CLIENT_COMMAND_SNAPSHOT 7

/**
 * What the tool that is the parameter grips, or touches, is held to the world where it is, by springs of the stiffness
 * that is the value [N/m]; infinity for a rigid pin. It takes the lowest free number, from 0. At a place
 * `chaincell_client_pin_at` sets one.
 */
#define CHAINCELL_CLIENT_COMMAND_PIN 8

/**
 * The pin that is the parameter is released within so many ticks as the value says.
 */
#define CHAINCELL_CLIENT_COMMAND_UNPIN 9

/**
 * Sweeps a tick, 1 to 1,000.
 */
#define CHAINCELL_CLIENT_PARAMETER_SWEEPS 1

/**
 * Largest force [N]; infinity for no limit.
 */
#define CHAINCELL_CLIENT_PARAMETER_MAX_FORCE 2

/**
 * Largest move of a tool a tick [m].
 */
#define CHAINCELL_CLIENT_PARAMETER_MAX_TOOL_STEP 3

/**
 * Unloading: 0 off, 1 release, 2 retreat.
 */
#define CHAINCELL_CLIENT_PARAMETER_UNLOADING 4

/**
 * Blades and tears: 0 on, 1 off.
 */
#define CHAINCELL_CLIENT_PARAMETER_CUT 7

/**
 * Most tools of a scene.
 */
#define CHAINCELL_CLIENT_TOOLS_MAX 8

/**
 * What a handle is for.
 */
enum chaincell_client_role
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Sends poses; a scene has one.
     */
    CHAINCELL_CLIENT_ROLE_CONTROLLER = 0,
    /**
     * Looks at states and contacts, and sends commands.
     */
    CHAINCELL_CLIENT_ROLE_VIEWER = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_client_role chaincell_client_role;
#else
typedef int32_t chaincell_client_role;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How to wait for answers.
 */
enum chaincell_client_wait
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Sleep until shortly before the answer is expected, poll for at most 200 us, then short sleeps.
     */
    CHAINCELL_CLIENT_WAIT_HYBRID = 0,
    /**
     * Poll all the time: the shortest answers, but only with a free core for each side.
     */
    CHAINCELL_CLIENT_WAIT_SPIN = 1,
    /**
     * Sleep until the server wakes this process: no polling, the longest answers.
     */
    CHAINCELL_CLIENT_WAIT_EVENT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_client_wait chaincell_client_wait;
#else
typedef int32_t chaincell_client_wait;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * An open scene; 0 is none. A number that was closed is never given again.
 */
typedef uint64_t chaincell_client;

/**
 * A node of a state: 16 bytes.
 */
typedef struct chaincell_client_node {
    /**
     * Id of the node in the input mesh.
     */
    uint32_t node;
    /**
     * Its position in the frame of the input mesh [m].
     */
    float position_m[3];
} chaincell_client_node;

/**
 * A state: 48 bytes, whose nodes lie in shared memory until it is released.
 */
typedef struct chaincell_client_states {
    /**
     * Number of the last answered tick, 0 before the first.
     */
    uint64_t tick;
    /**
     * Ticks answered since the server began.
     */
    uint64_t ticks_answered;
    /**
     * Hash of the state.
     */
    uint64_t state_hash;
    /**
     * Every node of the model, by ascending id; null where there are none.
     */
    const struct chaincell_client_node *nodes;
    /**
     * Number of nodes.
     */
    size_t count;
    /**
     * Flags of the last answer, a sum of CHAINCELL_FLAG_.
     */
    uint32_t flags;
    /**
     * Checksum of the model, as chaincell info prints it.
     */
    uint32_t model_checksum;
} chaincell_client_states;

/**
 * A triangle in contact with a part of a tool: 52 bytes.
 */
typedef struct chaincell_client_contact {
    /**
     * Which tool.
     */
    uint32_t tool;
    /**
     * Which of its parts.
     */
    uint32_t part;
    /**
     * Input id of the triangle's corner that takes the largest share.
     */
    uint32_t node;
    /**
     * Where it acts, in the frame of the input mesh [m].
     */
    float position_m[3];
    /**
     * Pressure on the tool [N].
     */
    float normal_n[3];
    /**
     * Friction, or the pull of a grip, on the tool [N].
     */
    float tangential_n[3];
    /**
     * Area of the triangle at rest, as far as its points are in contact [m2].
     */
    float area_m2;
} chaincell_client_contact;

/**
 * Contacts: 40 bytes; they lie in shared memory until they are released.
 */
typedef struct chaincell_client_touches {
    /**
     * Number of the last answered tick, 0 before the first.
     */
    uint64_t tick;
    /**
     * Ticks answered since the server began.
     */
    uint64_t ticks_answered;
    /**
     * The contacts; null where nothing is in contact.
     */
    const struct chaincell_client_contact *contacts;
    /**
     * Number of contacts.
     */
    size_t count;
    /**
     * Flags of the last answer, a sum of CHAINCELL_FLAG_.
     */
    uint32_t flags;
    /**
     * Zero.
     */
    uint32_t reserved;
} chaincell_client_touches;

/**
 * The reply to a command: 32 bytes.
 */
typedef struct chaincell_client_reply {
    /**
     * Number of the last tick answered before the command, 0 before the first.
     */
    uint64_t tick;
    /**
     * Ticks answered before the command since the server began.
     */
    uint64_t ticks_answered;
    /**
     * Hash of the state after the command.
     */
    uint64_t state_hash;
    /**
     * 0 done, 1 refused: nothing has changed.
     */
    uint32_t result;
    /**
     * Why it was refused, the number of the contract; when done, of a pin its number, else 0.
     */
    uint32_t reason;
} chaincell_client_reply;

/**
 * How to open a scene: 24 bytes; `CHAINCELL_CLIENT_OPTIONS_DEFAULT` initialises it.
 */
typedef struct chaincell_client_options {
    /**
     * One of `chaincell_client_role`.
     */
    int32_t role;
    /**
     * One of `chaincell_client_wait`.
     */
    int32_t wait;
    /**
     * Longest wait for a server, or of a viewer for one that shows a session of another place [ns], of which an hour
     * is waited at most; 10 s.
     */
    uint64_t server_wait_ns;
    /**
     * Time without an answer after which the force falls to 0, 0 for never [ms]; 20, at most 60,000.
     */
    uint32_t watchdog_ms;
    /**
     * Time in which it falls, and rises when answers come again; 0 for at once [ms]; 20, at most
     * 60,000.
     */
    uint32_t ramp_ms;
} chaincell_client_options;

/**
 * What to show at a moment: 400 bytes. Every force is finite, whatever has come.
 */
typedef struct chaincell_client_answer {
    /**
     * Number of the tick that was answered last, 0 before the first.
     */
    uint64_t tick;
    /**
     * Session of the server that answered, 0 before the first.
     */
    uint64_t session_id;
    /**
     * Number of the tick whose pose the force is of.
     */
    uint64_t force_tick;
    /**
     * Hash of the state after the tick, 0 where none was taken.
     */
    uint64_t state_hash;
    /**
     * From sending the pose to its answer [ns].
     */
    uint64_t round_trip_ns;
    /**
     * How long ago the answer came [ns].
     */
    uint64_t age_ns;
    /**
     * Answers that have come.
     */
    uint64_t answers;
    /**
     * Certified upper bound of the elastic energy of the tissue [J].
     */
    float energy_j;
    /**
     * What bit during the tick, a sum of CHAINCELL_FLAG_.
     */
    uint32_t flags;
    /**
     * What the client says itself, a sum of CHAINCELL_CLIENT_NOTE_.
     */
    uint32_t notes;
    /**
     * Time the tick took the server [ns].
     */
    uint32_t step_ns;
    /**
     * Sweeps made in the tick, 0 in a late one.
     */
    uint32_t sweeps;
    /**
     * Zero.
     */
    uint32_t reserved;
    /**
     * What each tool feels, by its number.
     */
    chaincell_tool_output tools[CHAINCELL_CLIENT_TOOLS_MAX];
    /**
     * Estimated error of each tool's force, before its limit [N]; below 0 where it is not known, where an output
     * stage answers another force than the tissue's, and while the client shows another force than the server's.
     */
    float force_error_n[CHAINCELL_CLIENT_TOOLS_MAX];
    /**
     * Estimated error of each tool's torque likewise, below 0 for held cells too [N m].
     */
    float torque_error_n_m[CHAINCELL_CLIENT_TOOLS_MAX];
} chaincell_client_answer;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * A code in words, for logs: never null, whatever the number. Of what this thread's last refused call has
 * answered it says the place and the remedy too, until the next one that is refused.
 */
const char *chaincell_client_error_text(int32_t code);

/**
 * Takes the newest state that was not taken yet, where it lies in shared memory, until
 * `chaincell_client_release`: 3 where none has come; where one is held already it is given once more
 * with -42. The first call joins the readers, allocates
 * and mostly gives 3. Not for the loop of a device: use a viewer's handle in another thread.
 *
 * Safety
 * `state` is null or, where aligned, storage for one.
 */
chaincell_client_code chaincell_client_state(chaincell_client client,
                                             struct chaincell_client_states *state);

/**
 * Takes the newest contacts that were not taken yet, as `chaincell_client_state` does; until
 * `chaincell_client_release`. A server without tools on a contact surface sends none.
 *
 * Safety
 * `contacts` is null or, where aligned, storage for one.
 */
chaincell_client_code chaincell_client_contacts(chaincell_client client,
                                                struct chaincell_client_touches *contacts);

/**
 * Gives back the state and the contacts that are held: they must not be read any more.
 */
chaincell_client_code chaincell_client_release(chaincell_client client);

/**
 * Sends a command and waits for its reply at most `wait_ns`: `kind` is one of CHAINCELL_CLIENT_COMMAND_,
 * `parameter` one of CHAINCELL_CLIENT_PARAMETER_, the tool or the pin, both and `value` 0 where the kind has none.
 * `reply` may be null. Not for the loop of a device.
 *
 * Safety
 * `reply` is null or, where aligned, storage for one.
 */
chaincell_client_code chaincell_client_command(chaincell_client client,
                                               uint32_t kind,
                                               uint32_t parameter,
                                               float value,
                                               uint64_t wait_ns,
                                               struct chaincell_client_reply *reply);

/**
 * Pins the surface within `radius_m` of a point, 3 numbers in the frame of the input mesh [m], where it is now:
 * it is held to the world by springs of `stiffness_n_per_m` in all, infinity for a rigid pin. Waits for the reply at
 * most `wait_ns`; `reply` may be null, its `reason` is the pin's number, the lowest free one. The command
 * CHAINCELL_CLIENT_COMMAND_UNPIN releases the pin. Not for the loop of a device.
 *
 * Safety
 * `point_m` is null or, where aligned, three numbers; `reply` is null or, where aligned, storage for one.
 */
chaincell_client_code chaincell_client_pin_at(chaincell_client client,
                                              const float *point_m,
                                              float radius_m,
                                              float stiffness_n_per_m,
                                              uint64_t wait_ns,
                                              struct chaincell_client_reply *reply);

/**
 * Opens a scene by its name, null for the unnamed one; without `options` by default. `version` is
 * CHAINCELL_CLIENT_VERSION. Waits for a server as the options say, allocates and maps memory: not for
 * the loop of a device. At most 64 clients a process.
 *
 * Safety
 * `scene` is null or a text that ends with a 0; `options` is null or, where aligned, options; `client`
 * is null or, where aligned, storage for a handle.
 */
chaincell_client_code chaincell_client_open(uint32_t version,
                                            const char *scene,
                                            const struct chaincell_client_options *options,
                                            chaincell_client *client);

/**
 * Leaves the scene: the server lets its force fall. What is held of states and contacts is gone with it.
 * A call of another thread that is under way keeps it to its end.
 */
chaincell_client_code chaincell_client_close(chaincell_client client);

/**
 * Sends the poses of `count` tools, 1 to 8, tool 0 first, waits for the answer at most `wait_ns`, and
 * gives what to show. Tools beyond `count` are not engaged. Where the poses are refused `shown` is
 * what to show now; where the handle is, it is all 0.
 *
 * One allocation of 104 bytes; it sleeps or polls as the options say.
 *
 * Safety
 * `poses` is null or, where aligned, `count` poses; `shown` is null or, where aligned, storage for one.
 */
chaincell_client_code chaincell_client_step(chaincell_client client,
                                            const chaincell_tool_pose *poses,
                                            size_t count,
                                            uint64_t wait_ns,
                                            struct chaincell_client_answer *shown);

/**
 * Sends the poses of tools and waits for nothing. `tick`, which may be null, gets the number of the tick.
 * One allocation of 104 bytes.
 *
 * Safety
 * `poses` is null or, where aligned, `count` poses; `tick` is null or, where aligned, storage for a
 * number.
 */
chaincell_client_code chaincell_client_send(chaincell_client client,
                                            const chaincell_tool_pose *poses,
                                            size_t count,
                                            uint64_t *tick);

/**
 * Takes all answers that have come, and gives what to show now: 0 where one came, else 1 or 2. Waits for
 * nothing and allocates nothing.
 *
 * Safety
 * `shown` is null or, where aligned, storage for one.
 */
chaincell_client_code chaincell_client_try_receive(chaincell_client client,
                                                   struct chaincell_client_answer *shown);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CHAINCELL_CLIENT_H */
