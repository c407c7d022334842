/*
 * chaincell: soft tissue that a haptic device can feel. The C interface of the kernel.
 *
 *   chaincell_model    a validated model, in storage of yours; the image stays where it is
 *   chaincell_tissue   a body, in storage of yours: CHAINCELL_TISSUE_BYTES or chaincell_model_size
 *   chaincell_tick     one tick, every millisecond: poses in, forces out
 *   chaincell_stage    between the two and a hand: coupling, passivity, limits, watchdog
 *
 * Every function that takes a pointer answers with a chaincell_code, 0 when all is well. None
 * unwinds. Pointers are checked for null and alignment. There is no heap and no global state:
 * several bodies may be ticked at the same time, each by one thread, and any number of threads may
 * read one model. The kernel computes in IEEE 754 single precision to nearest, denormals kept:
 * leave FTZ, DAZ, FZ and fast-math start-up code off.
 *
 * Written from kernel/ffi/src: change it there.
 */

#ifndef CHAINCELL_H
#define CHAINCELL_H

#include <stddef.h>
#include <stdint.h>

/* Puts an object where a tissue's storage or an image may start: first in its declaration.
 * CHAINCELL_SHAPE_ALIGNED does so for a tissue of nodal shapes. */
#if defined(__cplusplus)
#define CHAINCELL_ALIGNED alignas(16)
#define CHAINCELL_SHAPE_ALIGNED alignas(64)
#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L
#define CHAINCELL_ALIGNED _Alignas(16)
#define CHAINCELL_SHAPE_ALIGNED _Alignas(64)
#else
#define CHAINCELL_ALIGNED __attribute__((aligned(16)))
#define CHAINCELL_SHAPE_ALIGNED __attribute__((aligned(64)))
#endif

/* Whether a pointer is aligned for a tissue's storage and for an image. */
#define CHAINCELL_IS_ALIGNED(pointer) ((uintptr_t)(pointer) % CHAINCELL_ALIGN == 0)

/* Bytes of storage for a tissue of so many cells, contact cells and coarse functions: at least what
 * chaincell_model_size says, for use where a constant must stand:
 *
 *   CHAINCELL_ALIGNED static unsigned char storage[CHAINCELL_TISSUE_BYTES(512, 4, 0)];
 *
 * Enough for every scheme but rkl2; for schemes that need less or more CHAINCELL_TISSUE_BYTES_OF
 * takes one of the CHAINCELL_CELL_BYTES_ numbers, and 0 coarse functions for all but track and predict. */
#define CHAINCELL_TISSUE_BYTES(cells, contacts, coarse_functions) \
    CHAINCELL_TISSUE_BYTES_OF(CHAINCELL_CELL_BYTES_TRACK, cells, contacts, coarse_functions)
#define CHAINCELL_TISSUE_BYTES_OF(cell_bytes, cells, contacts, coarse_functions) \
    (CHAINCELL_TISSUE_BYTES_FIXED + CHAINCELL_TISSUE_WORDS_FIXED * sizeof(void *) + \
     (size_t)(cell_bytes) * (size_t)(cells) + (size_t)16 * (size_t)(contacts) + \
     ((size_t)2 * (size_t)(contacts) + 15) / 16 * 16 + \
     ((size_t)(coarse_functions) + 7) / 8 * (6 + (size_t)2 * (size_t)(contacts)) * 32)

/* Bytes for a tissue of nodal shapes, for track; cell_bytes as above:
 *
 *   CHAINCELL_SHAPE_ALIGNED static unsigned char storage[CHAINCELL_SHAPE_BYTES(512, 4, 48)]; */
#define CHAINCELL_SHAPE_BYTES(cells, contacts, coarse_functions) \
    CHAINCELL_SHAPE_BYTES_OF(CHAINCELL_CELL_BYTES_TRACK, cells, contacts, coarse_functions)
#define CHAINCELL_SHAPE_BYTES_OF(cell_bytes, cells, contacts, coarse_functions) \
    (CHAINCELL_TISSUE_BYTES_OF(cell_bytes, cells, contacts, 0) + CHAINCELL_SHAPE_ALIGN + \
     ((size_t)(coarse_functions) + 7) / 8 * 9 * 32 + \
     (size_t)CHAINCELL_CELL_BYTES_SHAPE * (((size_t)(cells) + 7) / 8 * 8))

/* Bytes that room for tools on a surface takes on top of that:
 *
 *   CHAINCELL_SHAPE_ALIGNED static unsigned char
 *       storage[CHAINCELL_SHAPE_BYTES(512, 4, 48) + CHAINCELL_TOUCH_BYTES(512, 2, 1024, 256)]; */
#define CHAINCELL_TOUCH_BYTES(cells, tools, triangles, samples) \
    (CHAINCELL_TOUCH_BYTES_FIXED + (size_t)CHAINCELL_CELL_BYTES_TOUCH * (size_t)(cells) + \
     (size_t)CHAINCELL_TOOL_BYTES * (size_t)(tools) + \
     (size_t)CHAINCELL_TRIANGLE_BYTES * (size_t)(triangles) + \
     (size_t)CHAINCELL_SAMPLE_BYTES * (size_t)(samples))

/* Bytes that so many samples that pins hold take on top of that. */
#define CHAINCELL_PIN_ROOM_BYTES(samples) ((size_t)CHAINCELL_PIN_BYTES * (size_t)(samples) + 16)

/* Bytes that memory for cuts takes on top of that, for so many words (`cut_words` of chaincell_info; a
 * quarter of the bytes of RAM that `chaincell info` prints for cutting) and tools; 0 words for a body
 * that stays whole, in a library that cuts. */
#define CHAINCELL_CUT_BYTES(words, tools) \
    ((size_t)4 * (size_t)(words) + (size_t)CHAINCELL_CUT_TOOL_BYTES * (size_t)(tools))

/**
 * The step limit or the energy limit shortened the tool's motion or the change of its current.
 */
#define CHAINCELL_FLAG_MOTION_CLAMPED 1

/**
 * A bad sample, no number or farther than a hand moves: the last good one is used, or the safe
 * state is on.
 */
#define CHAINCELL_FLAG_BAD_SAMPLE 2

/**
 * No sample within the watchdog's time (set by the output stage or the calling process).
 */
#define CHAINCELL_FLAG_STALE 4

/**
 * Force or torque was clamped to its limit.
 */
#define CHAINCELL_FLAG_FORCE_CLAMPED 8

/**
 * Safe state: the force is zero.
 */
#define CHAINCELL_FLAG_SAFE_STATE 16

/**
 * The links' bands are closed (unloading).
 */
#define CHAINCELL_FLAG_BAND_CLOSED 32

/**
 * The energy guard discarded a pass.
 */
#define CHAINCELL_FLAG_ROLLED_BACK 64

/**
 * More triangles are in reach of the tools, or more samples in contact, than the tissue has memory
 * for: the farthest ones are left out.
 */
#define CHAINCELL_FLAG_CONTACT_CAPACITY 128

/**
 * The sample was late, as newer ones waited or the tissue cannot keep up: it was executed without a
 * sweep, and the force is that of an earlier tick.
 */
#define CHAINCELL_FLAG_LATE 256

/**
 * The tool counts as not engaged until it has been released once (set by the calling process).
 */
#define CHAINCELL_FLAG_RELEASE_FIRST 512

/**
 * The output stage lowers the force along its ramp or holds it back: passivity control cannot
 * compensate the energy that sampling and delay generate, or the hand has put in too little energy.
 */
#define CHAINCELL_FLAG_FORCE_WITHHELD 1024

/**
 * A tool engaged inside the tissue, or the tissue closed over it while it grew: it has no contact and
 * no force until it has been outside once.
 */
#define CHAINCELL_FLAG_STARTS_INSIDE 2048

/**
 * What a call came to: 0 when all is well, negative when it was refused.
 *
 * A number never changes its meaning; `chaincell_code_text` says it in words.
 */
enum chaincell_code
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done.
     */
    CHAINCELL_CODE_OK = 0,
    /**
     * A pointer is null.
     */
    CHAINCELL_CODE_NULL = -1,
    /**
     * A pointer does not have the alignment of what it points to.
     */
    CHAINCELL_CODE_MISALIGNED = -2,
    /**
     * The storage is too small: `needed` and `available` bytes.
     */
    CHAINCELL_CODE_STORAGE = -3,
    /**
     * No model or tissue stands there: initialise it first.
     */
    CHAINCELL_CODE_NOT_INITIALISED = -4,
    /**
     * No such scheme.
     */
    CHAINCELL_CODE_SCHEME = -5,
    /**
     * A number is out of its range: the model's number of cells bounds it, or what its function or
     * field says; `needed` what was asked for, `available` the most.
     */
    CHAINCELL_CODE_RANGE = -6,
    /**
     * No cell has this input id: `position` in the list.
     */
    CHAINCELL_CODE_UNKNOWN_ID = -7,
    /**
     * A body of links has no stress.
     */
    CHAINCELL_CODE_NO_STRESS = -8,
    /**
     * The image does not start at a multiple of 16.
     */
    CHAINCELL_CODE_MODEL_MISALIGNED = -20,
    /**
     * The image ends before it is complete.
     */
    CHAINCELL_CODE_MODEL_TRUNCATED = -21,
    /**
     * The first bytes are not those of a model image.
     */
    CHAINCELL_CODE_MODEL_MAGIC = -22,
    /**
     * The image has format `available`, this library reads `needed`.
     */
    CHAINCELL_CODE_MODEL_VERSION = -23,
    /**
     * The checksum does not match: the bytes were changed after the bake.
     */
    CHAINCELL_CODE_MODEL_CHECKSUM = -24,
    /**
     * The header or the section table contradicts itself.
     */
    CHAINCELL_CODE_MODEL_LAYOUT = -25,
    /**
     * A required section is missing: `section`.
     */
    CHAINCELL_CODE_MODEL_MISSING = -26,
    /**
     * A section has a version that this library does not read: `section`.
     */
    CHAINCELL_CODE_MODEL_SECTION_VERSION = -27,
    /**
     * A section has the wrong size: `section`.
     */
    CHAINCELL_CODE_MODEL_SECTION_SIZE = -28,
    /**
     * A scalar of the body is out of range: `position` is its word.
     */
    CHAINCELL_CODE_MODEL_PARAMETER = -29,
    /**
     * An index is out of range or order: `section`, `position`.
     */
    CHAINCELL_CODE_MODEL_INDEX = -30,
    /**
     * A number is not finite or out of range: `section`, `position`.
     */
    CHAINCELL_CODE_MODEL_VALUE = -31,
    /**
     * `sweeps` is not in 1 to 65,535.
     */
    CHAINCELL_CODE_SETTINGS_SWEEPS = -40,
    /**
     * `step` is not above 0 and at most `limit`, the model's proven bound.
     */
    CHAINCELL_CODE_SETTINGS_STEP = -41,
    /**
     * `tick_time` is not finite, or below `limit`.
     */
    CHAINCELL_CODE_SETTINGS_TICK_TIME = -42,
    /**
     * `max_tool_step_m` is not positive and finite.
     */
    CHAINCELL_CODE_SETTINGS_MAX_TOOL_STEP = -43,
    /**
     * `max_force_n` is not positive.
     */
    CHAINCELL_CODE_SETTINGS_MAX_FORCE = -44,
    /**
     * `unloading` is none of its three values, or not off where links relax.
     */
    CHAINCELL_CODE_SETTINGS_UNLOADING = -45,
    /**
     * `drive` is neither of its two values.
     */
    CHAINCELL_CODE_SETTINGS_DRIVE = -46,
    /**
     * `cut` is neither of its two values.
     */
    CHAINCELL_CODE_SETTINGS_CUT = -47,
    /**
     * The tissue has too few cells for the model: `needed`, `available`.
     */
    CHAINCELL_CODE_RESET_CAPACITY = -60,
    /**
     * Too little room for the coarse level: `needed`, `available` blocks of eight `float`.
     */
    CHAINCELL_CODE_RESET_COARSE = -61,
    /**
     * The thread's arithmetic flushes denormals to zero (FTZ, DAZ or FZ is on).
     */
    CHAINCELL_CODE_FLOAT_FLUSH_TO_ZERO = -63,
    /**
     * The thread's arithmetic does not round to nearest.
     */
    CHAINCELL_CODE_FLOAT_ROUNDING = -64,
    /**
     * The model leaves the range of the scheme's numbers: `limit` is the one that it leaves.
     */
    CHAINCELL_CODE_RESET_RANGE = -65,
    /**
     * A body of nodal shapes needs track or predict.
     */
    CHAINCELL_CODE_RESET_SHAPES = -66,
    /**
     * Floating-point exceptions stop the program on this thread.
     */
    CHAINCELL_CODE_FLOAT_TRAP = -67,
    /**
     * More contact cells than the tissue has room for: `needed`, `available`.
     */
    CHAINCELL_CODE_CONTACT_CAPACITY = -80,
    /**
     * The contact cell is not in the model: `position` in the list.
     */
    CHAINCELL_CODE_CONTACT_UNKNOWN = -81,
    /**
     * The contact cell is fixed: `position` in the list.
     */
    CHAINCELL_CODE_CONTACT_FIXED = -82,
    /**
     * The contact cell is named twice: `position` of the second one in the list.
     */
    CHAINCELL_CODE_CONTACT_REPEATED = -83,
    /**
     * The tissue belongs to another model.
     */
    CHAINCELL_CODE_CONTACT_MODEL = -84,
    /**
     * Too little room to hold that many cells beside the coarse level: `needed`, `available`
     * blocks of eight `float`.
     */
    CHAINCELL_CODE_CONTACT_COARSE = -85,
    /**
     * The tool is engaged: other cells can be chosen only while it is released.
     */
    CHAINCELL_CODE_CONTACT_ENGAGED = -86,
    /**
     * This library or scheme has no contact with tools: take track or predict.
     */
    CHAINCELL_CODE_CONTACT_SCHEME = -90,
    /**
     * Tools meet the triangles of a surface, and this model has none: bake it with
     * `--contact-surface yes`.
     */
    CHAINCELL_CODE_CONTACT_NO_SURFACE = -91,
    /**
     * No tools, or more than the tissue has room for: `needed`, `available`.
     */
    CHAINCELL_CODE_CONTACT_TOOLS = -92,
    /**
     * A tool has no parts, or too many: `position` is the tool, `needed` its parts, `available` the
     * most.
     */
    CHAINCELL_CODE_CONTACT_PARTS = -93,
    /**
     * A part of a tool cannot be: `position` in the list of all parts.
     */
    CHAINCELL_CODE_CONTACT_PART = -94,
    /**
     * Friction is not within 0 and `limit`.
     */
    CHAINCELL_CODE_CONTACT_FRICTION = -95,
    /**
     * Friction holds samples, and the tissue has no room for any.
     */
    CHAINCELL_CODE_CONTACT_SAMPLES = -96,
    /**
     * The tissue has no room for contact on surfaces: `needed` cells, `available`.
     */
    CHAINCELL_CODE_CONTACT_ROOM = -97,
    /**
     * A radius is below `limit`, the smallest that this model's surface takes [m].
     */
    CHAINCELL_CODE_CONTACT_RADIUS_MIN = -98,
    /**
     * The tissue belongs to another model.
     */
    CHAINCELL_CODE_STATE_MODEL = -100,
    /**
     * More or fewer positions than cells: `needed`, `available`.
     */
    CHAINCELL_CODE_STATE_COUNT = -101,
    /**
     * A coordinate is not finite or too large: `position` is its cell.
     */
    CHAINCELL_CODE_STATE_POSITION = -102,
    /**
     * `tick_s` is not within 1e-5 to 1.
     */
    CHAINCELL_CODE_STAGE_TICK = -120,
    /**
     * The coupling's stiffness or damping is negative or above 1e6.
     */
    CHAINCELL_CODE_STAGE_COUPLING = -121,
    /**
     * The device's damping is negative or above 1e6, or the delay above 16 ticks, without a
     * coupling above 1.
     */
    CHAINCELL_CODE_STAGE_PASSIVITY = -122,
    /**
     * `max_slew_n_per_s` is not positive.
     */
    CHAINCELL_CODE_STAGE_SLEW = -123,
    /**
     * The stage's `max_force_n` is not positive.
     */
    CHAINCELL_CODE_STAGE_MAX_FORCE = -124,
    /**
     * `ramp_ticks` or `watchdog_ticks` is above 60,000.
     */
    CHAINCELL_CODE_STAGE_TICKS = -125,
    /**
     * No such device.
     */
    CHAINCELL_CODE_STAGE_DEVICE = -126,
    /**
     * The stage's `max_speed_m_per_s` is not positive.
     */
    CHAINCELL_CODE_STAGE_MAX_SPEED = -127,
    /**
     * The buffer is shorter than the snapshot: `needed`, `available` bytes.
     */
    CHAINCELL_CODE_SNAPSHOT_BUFFER = -140,
    /**
     * The bytes are no snapshot.
     */
    CHAINCELL_CODE_SNAPSHOT_MAGIC = -141,
    /**
     * Another version of snapshots: `needed`, `available`.
     */
    CHAINCELL_CODE_SNAPSHOT_VERSION = -142,
    /**
     * The snapshot is of another scheme or release.
     */
    CHAINCELL_CODE_SNAPSHOT_LAYOUT = -143,
    /**
     * The snapshot is of another model.
     */
    CHAINCELL_CODE_SNAPSHOT_MODEL = -144,
    /**
     * The snapshot is not whole.
     */
    CHAINCELL_CODE_SNAPSHOT_LENGTH = -145,
    /**
     * The snapshot's checksum does not match.
     */
    CHAINCELL_CODE_SNAPSHOT_CHECKSUM = -146,
    /**
     * A value that cannot be: `position` is its word behind the header.
     */
    CHAINCELL_CODE_SNAPSHOT_VALUE = -147,
    /**
     * Too little room for what the snapshot has: `needed`, `available`.
     */
    CHAINCELL_CODE_SNAPSHOT_ROOM = -148,
    /**
     * This model's body cannot be cut.
     */
    CHAINCELL_CODE_CUT_MODEL = -160,
    /**
     * The tissue has no memory for cuts.
     */
    CHAINCELL_CODE_CUT_ROOM = -161,
    /**
     * The model has no such face: `position` in the list.
     */
    CHAINCELL_CODE_CUT_FACE = -162,
    /**
     * Pins hold the surface that tools touch, and no tools are chosen.
     */
    CHAINCELL_CODE_PIN_TOOLS = -180,
    /**
     * Point, radius or stiffness of a pin cannot be.
     */
    CHAINCELL_CODE_PIN_VALUE = -181,
    /**
     * No sample of the surface lies within the radius; `limit` is the distance of the nearest one [m].
     */
    CHAINCELL_CODE_PIN_REACH = -182,
    /**
     * Too little room for the samples of the pin: `needed`, `available`.
     */
    CHAINCELL_CODE_PIN_ROOM = -183,
    /**
     * The tool neither grips nor touches the tissue: `position`.
     */
    CHAINCELL_CODE_PIN_NOTHING_HELD = -184,
    /**
     * No pin has this number.
     */
    CHAINCELL_CODE_PIN_UNKNOWN = -185,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_code chaincell_code;
#else
typedef int32_t chaincell_code;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A haptic device by its published limits.
 */
enum chaincell_device
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * 3D Systems Touch: 3.3 N, 400 N/m.
     */
    CHAINCELL_DEVICE_TOUCH = 0,
    /**
     * 3D Systems Phantom Premium 3.0: 22 N, 1000 N/m.
     */
    CHAINCELL_DEVICE_PREMIUM = 1,
    /**
     * Novint Falcon: 8 N, 3000 N/m.
     */
    CHAINCELL_DEVICE_FALCON = 2,
    /**
     * Force Dimension omega: 12 N, 5000 N/m.
     */
    CHAINCELL_DEVICE_OMEGA = 3,
    /**
     * Force Dimension sigma.7: 12 N, 4000 N/m.
     */
    CHAINCELL_DEVICE_SIGMA = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_device chaincell_device;
#else
typedef int32_t chaincell_device;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * When the links' bands close.
 */
enum chaincell_unloading
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Never.
     */
    CHAINCELL_UNLOADING_OFF = 0,
    /**
     * From the tool's release until it engages again.
     */
    CHAINCELL_UNLOADING_RELEASE = 1,
    /**
     * Like `release`, and also while the tool has retreated by more than a tenth of a mean link length
     * from its deepest point, until it passes that point.
     */
    CHAINCELL_UNLOADING_RETREAT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_unloading chaincell_unloading;
#else
typedef int32_t chaincell_unloading;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Effect of the tool's displacement.
 */
enum chaincell_drive
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * It prescribes their positions: the cells are held where the tool has them.
     */
    CHAINCELL_DRIVE_POSITION = 0,
    /**
     * It is the current into each of them, a load of 2 k times the displacement [N]; a body that nothing
     * fixes drifts.
     */
    CHAINCELL_DRIVE_CURRENT = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_drive chaincell_drive;
#else
typedef int32_t chaincell_drive;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Cutting by blades and tearing.
 */
enum chaincell_cutting
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * A blade cuts a body that can be cut, and one that tears does.
     */
    CHAINCELL_CUTTING_ON = 0,
    /**
     * No face opens: a blade feels nothing and leaves the tissue that it is in, and no cell tears. What is open
     * stays open, and splits that wait are made.
     */
    CHAINCELL_CUTTING_OFF = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_cutting chaincell_cutting;
#else
typedef int32_t chaincell_cutting;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Parameters of a run.
 */
typedef struct chaincell_settings {
    /**
     * Sweeps per tick, 1 to 65,535.
     */
    uint32_t sweeps;
    /**
     * Time that `euler` advances per sweep, at most the model's bound `step_max`; on the command line and in
     * Python also the time that `rkl2` advances per tick [dimensionless].
     */
    float step;
    /**
     * Time that `rkl2` advances per tick, at least 1e-12 of `step_max` [dimensionless].
     */
    float tick_time;
    /**
     * Largest motion of the contact cells per tick, or largest change of the current per tick [m].
     */
    float max_tool_step_m;
    /**
     * Largest magnitude of the force; a larger one is shortened and flagged. A limit below 1e-15 N admits no
     * force, an infinite one is none [N].
     */
    float max_force_n;
    /**
     * When the links' bands close to their rest lengths. Those of links that relax stay open: unloading lies
     * below loading by itself.
     * One of `chaincell_unloading`.
     */
    int32_t unloading;
    /**
     * How the tool's displacement acts on chosen cells, from the next time that the tool engages.
     * One of `chaincell_drive`.
     */
    int32_t drive;
    /**
     * Cutting by blades and tearing; off, a blade feels nothing and no body tears.
     * One of `chaincell_cutting`.
     */
    int32_t cut;
} chaincell_settings;

/**
 * Settings of the output stage; each part may be absent.
 */
typedef struct chaincell_stage_settings {
    /**
     * Time of a tick, 1e-5 to 1 [s].
     */
    float tick_s;
    /**
     * A spring and damper between the device and the tool in the tissue.
     * Other than 0 if it is there.
     */
    uint32_t coupling;
    /**
     * Stiffness, 1 to 1e6 [N/m].
     */
    float coupling_n_per_m;
    /**
     * Damping, 0 to 1e6 [N s/m].
     */
    float coupling_n_s_per_m;
    /**
     * Assumptions of the passivity observer about the device. If the controller cannot compensate the
     * generated energy, the force is lowered along the ramp, which needs `ramp_ticks` of 2 or more.
     * Other than 0 if it is there.
     */
    uint32_t passivity;
    /**
     * Damping that the device's mechanics have at least, 0 to 1e6 [N s/m].
     */
    float device_damping_n_s_per_m;
    /**
     * Ticks between an answer and the device's force, 0 to 16, without a coupling 0 or 1: 0 if the force of
     * a tick acts from that tick's sample to the next, 1 if it acts a tick later. From 2 on the coupling
     * shows at most 0.65 of the stiffness that is passive with this delay.
     */
    uint32_t delay_ticks;
    /**
     * Largest change of the force, infinite for none [N/s].
     */
    float max_slew_n_per_s;
    /**
     * Largest force, infinite for none [N].
     */
    float max_force_n;
    /**
     * Largest speed of the hand, infinite for none: an engaged pose that is farther from the last one than
     * this allows is a bad sample [m/s].
     */
    float max_speed_m_per_s;
    /**
     * Ticks in which the force rises to its full value after engaging and after a silence, and in which it
     * falls to zero when samples stop; 0 for none, at most 60,000.
     */
    uint32_t ramp_ticks;
    /**
     * Ticks without a sample after which the force falls to zero, 0 for never, at most 60,000.
     */
    uint32_t watchdog_ticks;
} chaincell_stage_settings;


/**
 * Version of this interface: major 65,536, minor 256, patch 1.
 */
#define CHAINCELL_VERSION 2816

/**
 * Bytes that a blade takes in each tool, in a library that cuts.
 */
#define CHAINCELL_CUT_TOOL_BYTES 1296

/**
 * At most so many bytes stand before a tissue's arrays, and so many words of the size of an
 * address (the next number): what `CHAINCELL_TISSUE_BYTES` goes by.
 */
#define CHAINCELL_TISSUE_BYTES_FIXED 2496

/**
 * Those words.
 */
#define CHAINCELL_TISSUE_WORDS_FIXED 142

/**
 * Bytes a cell under track.
 */
#define CHAINCELL_CELL_BYTES_TRACK 64

/**
 * Bytes a cell under euler.
 */
#define CHAINCELL_CELL_BYTES_EULER 32

/**
 * Bytes a cell under rkl2.
 */
#define CHAINCELL_CELL_BYTES_RKL2 80

/**
 * Bytes a cell under predict, the most of all schemes.
 */
#define CHAINCELL_CELL_BYTES_PREDICT 112

/**
 * Bytes a cell of nodal shapes takes more, the number of cells rounded up to a multiple of eight.
 */
#define CHAINCELL_CELL_BYTES_SHAPE 144

/**
 * Alignment of a tissue's storage [bytes].
 */
#define CHAINCELL_ALIGN 16

/**
 * The same for a body of nodal shapes [bytes].
 */
#define CHAINCELL_SHAPE_ALIGN 64

/**
 * Words of a `chaincell_model`.
 */
#define CHAINCELL_MODEL_WORDS 168

/**
 * Words of a `chaincell_stage`.
 */
#define CHAINCELL_STAGE_WORDS 160

/**
 * At most so many bytes the room for contact on surfaces takes beside those of the five numbers
 * below: what `CHAINCELL_TOUCH_BYTES` goes by.
 */
#define CHAINCELL_TOUCH_BYTES_FIXED 20480

/**
 * Bytes of that room for each cell of the model.
 */
#define CHAINCELL_CELL_BYTES_TOUCH 24

/**
 * Bytes for each triangle in reach.
 */
#define CHAINCELL_TRIANGLE_BYTES 28

/**
 * Bytes for each sample that friction or grips hold.
 */
#define CHAINCELL_SAMPLE_BYTES 104

/**
 * Bytes for each sample that pins hold.
 */
#define CHAINCELL_PIN_BYTES 48

/**
 * At most so many bytes for each tool; `CHAINCELL_CUT_BYTES` has what a blade takes more.
 */
#define CHAINCELL_TOOL_BYTES 1216

/**
 * The scheme that moves the network.
 */
enum chaincell_scheme
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Follows the equilibrium: conjugate directions under an energy guard, with the model's coarse functions.
     */
    CHAINCELL_SCHEME_TRACK = 0,
    /**
     * One explicit step of common size a sweep: relaxation in time, 32 bytes a cell.
     */
    CHAINCELL_SCHEME_EULER = 1,
    /**
     * Runge-Kutta-Legendre super-steps of second order: the trajectory in time beyond the bound of
     * euler.
     */
    CHAINCELL_SCHEME_RKL2 = 3,
    /**
     * Track in fixed point, for targets without an FPU; without a coarse level.
     */
    CHAINCELL_SCHEME_TRACK_FIXED = 5,
    /**
     * Euler in fixed point.
     */
    CHAINCELL_SCHEME_EULER_FIXED = 6,
    /**
     * Track that knows how the body answers a move of the chosen cells: 112 bytes a cell. Not in a
     * library that was built without the feature `predict`.
     */
    CHAINCELL_SCHEME_PREDICT = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum chaincell_scheme chaincell_scheme;
#else
typedef int32_t chaincell_scheme;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A body in storage of the caller's. It may be moved and copied byte by byte to storage of the
 * same alignment.
 */
typedef struct chaincell_tissue chaincell_tissue;

/**
 * A face of a tetrahedron.
 */
typedef struct chaincell_face {
    /**
     * The tetrahedron, by its place in the input mesh.
     */
    uint32_t tetrahedron;
    /**
     * The corner that lies opposite to the face, 0 to 3.
     */
    uint32_t corner;
} chaincell_face;

/**
 * State of the cuts of a body since its reset; all 0 for one that is whole.
 */
typedef struct chaincell_cuts {
    /**
     * Number of faces between tetrahedra that are open.
     */
    uint32_t opened_faces;
    /**
     * Number of spare cells in use: copies of split cells.
     */
    uint32_t copies;
    /**
     * Number of cells that wait for the start of a tick.
     */
    uint32_t waiting;
    /**
     * Number of splits for which there was no spare cell or half-link: bake with more, `--cut-spare`.
     */
    uint32_t refused;
    /**
     * Area that the edges of blades have swept [m2].
     */
    float area_m2;
    /**
     * Work that it took to part it: toughness times area, each area by the toughness there [J].
     */
    float work_j;
    /**
     * Number of open faces that tools do not touch, for want of places.
     */
    uint32_t untouched;
    /**
     * Number of cells at which a body that tears has torn by itself.
     */
    uint32_t torn;
} chaincell_cuts;

/**
 * Where and by how much a call was refused; what a code does not name is 0.
 */
typedef struct chaincell_detail {
    /**
     * Section of the image, a number as in the kernel's `image::kind`.
     */
    uint32_t section;
    /**
     * Position in the section, in the list or among the cells.
     */
    uint32_t position;
    /**
     * What is needed, in the code's own unit.
     */
    size_t needed;
    /**
     * What is there, in the same unit.
     */
    size_t available;
    /**
     * Largest or smallest admitted value, in the code's own unit: a step [dimensionless time],
     * the number that the model leaves, a radius [m], or friction.
     */
    float limit;
} chaincell_detail;

/**
 * A triangle of the surface of a body as it is cut now, outward.
 */
typedef struct chaincell_triangle {
    /**
     * Its three cells, as `chaincell_positions` numbers them; a cell behind those of the body is a copy that a split
     * has made.
     */
    uint32_t cells[3];
    /**
     * The cells of the whole body that these are or were made from: for colours, textures and positions at rest.
     */
    uint32_t origins[3];
} chaincell_triangle;

/**
 * Storage of a validated model. Its content is nobody's business; it may be copied.
 *
 * The model refers to its image, which stays where it is, unchanged, for as long as the model or
 * a tissue made from it is in use.
 */
typedef struct chaincell_model {
    /**
     * Not for use.
     */
    size_t opaque[CHAINCELL_MODEL_WORDS];
} chaincell_model;

/**
 * What a model says of itself.
 */
typedef struct chaincell_info {
    /**
     * Number of cells.
     */
    uint32_t cells;
    /**
     * Number of links.
     */
    uint32_t links;
    /**
     * Number of coarse functions of the coarse level, 0 without one.
     */
    uint32_t coarse_functions;
    /**
     * Number of fixed cells.
     */
    uint32_t fixed;
    /**
     * Number of connected parts.
     */
    uint32_t parts;
    /**
     * Number of nodes of the input's numbering: input ids lie below it.
     */
    uint32_t input_nodes;
    /**
     * Checksum of the image; it tells models apart.
     */
    uint32_t checksum;
    /**
     * Mean link length, the unit of internal positions [m].
     */
    float unit_m;
    /**
     * The body's centre, origin of internal positions [m].
     */
    float centre_m[3];
    /**
     * Stiffness of a link of weight 1 [N/m].
     */
    float stiffness_n_per_m;
    /**
     * Half-width of the links' band [rest lengths]; the mean where links differ.
     */
    float alpha;
    /**
     * Largest proven step of euler [dimensionless time].
     */
    float step_max;
    /**
     * Largest energy that a tool may load into the body [J].
     */
    float energy_max_j;
    /**
     * Words of memory for cuts or for the strain of a body that relaxes, 0 for another one: for `CHAINCELL_CUT_BYTES`.
     */
    uint32_t cut_words;
} chaincell_info;

/**
 * What a pin bears.
 */
typedef struct chaincell_pin_output {
    /**
     * Force of the tissue on the pin; no limit clamps it [N].
     */
    float force_n[3];
    /**
     * The mean of the places at which its samples are pinned, in the frame of the input mesh [m].
     */
    float position_m[3];
    /**
     * How far the tissue has moved from there, the mean of its samples [m].
     */
    float given_m[3];
    /**
     * Its present stiffness, which falls to 0 while it is released [N/m].
     */
    float stiffness_n_per_m;
    /**
     * Energy of its springs [J].
     */
    float energy_j;
    /**
     * Samples of the surface that it holds.
     */
    uint32_t samples;
} chaincell_pin_output;

/**
 * Storage of an output stage. Its content is nobody's business; it may be copied, and refers to
 * nothing.
 */
typedef struct chaincell_stage {
    /**
     * Not for use.
     */
    uint32_t opaque[CHAINCELL_STAGE_WORDS];
} chaincell_stage;

/**
 * Where a tool is. Any bits are admitted: a pose that is not finite, whose `engaged` is neither 0 nor
 * 1, whose opening is above 32768 or whose quaternion is not of length 1/2 to 2 makes the sample a bad one. Held
 * cells go by the position alone, but the quaternion has to be one: 0, 0, 0, 1 for no turn.
 */
typedef struct chaincell_tool_pose {
    /**
     * Where its frame is in the frame of the input mesh [m].
     */
    float position_m[3];
    /**
     * Turns its frame into that of the mesh: a unit quaternion x, y, z, w.
     */
    float orientation[4];
    /**
     * 1 while the tissue feels it (it holds the contact cells, or touches), else 0.
     */
    uint16_t engaged;
    /**
     * Opening angle between the blades of scissors in 2^-16 of a full turn, 0 to 32768; other tools ignore it.
     */
    uint16_t opening_turns_q16;
} chaincell_tool_pose;

/**
 * What a stage has to know of the time since its last sample.
 */
typedef struct chaincell_stage_news {
    /**
     * Ticks from a sample to the device's pushing with its answer, as they were measured; negative where
     * nobody did. What is shown follows the mean of the last 256 or so.
     */
    int32_t delay_ticks;
    /**
     * Other than 0 where the device did not feel what was computed: its force was let fall, or it was given
     * none, as in a pause or before a restored session. The ramp begins anew.
     */
    uint32_t restarts_ramp;
    /**
     * No force is above this from here on, besides the stage's own largest: for the `max_force_n` of the
     * tissue's settings, which shortens the tissue's force alone while a coupling shows its own. Up to a
     * higher one the force may grow by the device's largest within `ramp_ticks` [N]. 0 leaves it.
     */
    float max_force_n;
} chaincell_stage_news;

/**
 * What a tool feels in a tick, of the kernel and of the client alike.
 */
typedef struct chaincell_tool_output {
    /**
     * Force of the tissue on the tool [N].
     */
    float force_n[3];
    /**
     * Torque on it about its position; 0 for held cells [N m].
     */
    float torque_n_m[3];
    /**
     * Number of cells it holds, or of triangles that it is in contact with or whose samples it grips.
     */
    uint32_t contacts;
    /**
     * Limits and events, a sum of `CHAINCELL_FLAG_` numbers.
     */
    uint32_t flags;
} chaincell_tool_output;

/**
 * What one tick answers to a tool. It describes the state after the last update.
 */
typedef struct chaincell_output {
    /**
     * What the tool feels. The flags are those of the tick.
     */
    struct chaincell_tool_output tool;
    /**
     * Certified level: an upper bound of the elastic energy of the published state [J].
     */
    float energy_j;
    /**
     * What the motion of the tool in this tick did to the tissue, exactly: the tissue's side of an energy
     * ledger, including the work of the torque [J].
     */
    float work_j;
    /**
     * Upper bound of the stiffness that the tool meets within a tick [N/m].
     */
    float stiffness_n_per_m;
    /**
     * Sweeps made: 0 where the sample was late, and in the safe state.
     */
    uint32_t sweeps;
    /**
     * Energy that a body that relaxes has lost by relaxation since its reset, 0 for another one: the work of the
     * tools that neither the body holds nor a sweep took [J].
     */
    float relaxed_j;
    /**
     * Estimate of the distance between the force, before its limit, and that of the body in equilibrium with the
     * tools where they are: within it are 99 of 100 errors. Below 0 where none is known: away from the tissue, after a
     * shortened motion, in late ticks after one, a release or a restore and of cells held in a body that relaxes,
     * under another scheme than `predict`, and of bodies of links, without a coarse level, or cut [N].
     */
    float force_error_n;
    /**
     * Estimate of the error of the torque on the tool likewise, below 0 for held cells too [N m].
     */
    float torque_error_n_m;
} chaincell_output;

/**
 * How much a tissue has room for, beside the cells of its model.
 */
typedef struct chaincell_room {
    /**
     * Contact cells, at most those of the model; tools on a surface need none.
     */
    uint32_t contacts;
    /**
     * Tools on a surface, at most 8; 0 for no contact on surfaces, and then the two below and `pins`
     * are 0 too.
     */
    uint32_t tools;
    /**
     * Triangles in reach of tools at a time, 1 to 65,535; 1,024 are enough for most. A triangle
     * counts once for each part of a tool. Where more are in reach those deepest in the tools are
     * kept, with `CHAINCELL_FLAG_CONTACT_CAPACITY`.
     */
    uint32_t triangles;
    /**
     * Samples of triangles that friction or grips hold at a time, at most 32,767; 0 for neither.
     * A triangle has at least four. Where more are in contact the others are free, with
     * `CHAINCELL_FLAG_CONTACT_CAPACITY`.
     */
    uint32_t samples;
    /**
     * 1 for memory with which the model's body can be cut, 0 for a body that stays whole. A blade needs it, with
     * room for its tool.
     */
    uint32_t cuts;
    /**
     * Samples of triangles that all pins together hold at a time, at most 65,535, in a library with the feature
     * `pins`; 0 for no pins.
     */
    uint32_t pins;
} chaincell_room;

/**
 * Strain and stress of the tissue around a cell.
 */
typedef struct chaincell_cell_stress {
    /**
     * Principal stretches, the largest first.
     */
    float stretches[3];
    /**
     * Cauchy stress xx, yy, zz, xy, yz, xz, above 0 where the tissue is pulled [Pa].
     */
    float cauchy_pa[6];
    /**
     * Stress after von Mises: that of a bar under tension is its tension [Pa].
     */
    float von_mises_pa;
    /**
     * Mean stress, a third of the trace: below 0 where the tissue is pressed from all sides [Pa].
     */
    float mean_pa;
} chaincell_cell_stress;

/**
 * Asked after each sweep but the last, with the number of sweeps done and the caller's pointer;
 * other than 0 for a further one.
 */
typedef int32_t (*chaincell_more)(uint32_t done, void *context);

/**
 * How many sweeps a tick makes, at most those of the settings. Under `euler` and `rkl2` the sweeps are
 * the tissue's time: there all are made, whatever the budget.
 */
typedef struct chaincell_budget {
    /**
     * At most so many. 0 for a tick that is late, newer poses waiting: the tool moves, within its
     * limits, without a sweep; the answer repeats the last force, with `CHAINCELL_FLAG_LATE`, and is 0
     * where the tool lets go. Tools on a contact surface stay until the next tick with a sweep.
     */
    uint32_t sweeps;
    /**
     * Null, or whether to go on: at least one sweep is made.
     */
    chaincell_more more;
    /**
     * What `more` is called with.
     */
    void *context;
    /**
     * 0, or the share of each force at which its estimated error, `force_error_n`, is small enough: no sweep follows.
     * Where the error is not known, and as contact begins, the other limits alone count.
     */
    float force_error_share;
} chaincell_budget;

/**
 * A convex part of a tool with rounded edges, in the tool's frame. Any bits are admitted: a part
 * that cannot be is refused.
 */
typedef struct chaincell_tool_part {
    /**
     * Its middle [m].
     */
    float centre_m[3];
    /**
     * Turns its own frame into the tool's: a unit quaternion x, y, z, w.
     */
    float orientation[4];
    /**
     * Half the edges of its core [m]: 0 0 0 for a sphere, 0 0 a for a capsule along z, a b c for a
     * box. Of a half space the core is all that lies below z = -radius: infinite in every axis. Of the
     * edge of a blade half its length, 0, 0: it lies along x and cuts towards -z, and is the last part of its tool.
     * Of scissors half the largest thickness between the blades, 0, their length: see `radius_m`.
     */
    float half_m[3];
    /**
     * Radius of the rounded edges around the core, above 0 [m]; 0 for the edge of a blade. Tissue is never
     * pushed deeper into the tool than half of it. Below 0 for scissors: its negative is the distance at which
     * the edges pass the pivot. Their blades extend along -z and open in the y direction by the angle of the pose;
     * where the edges cross they cut.
     */
    float radius_m;
} chaincell_tool_part;

/**
 * The contact of one triangle with one part of a tool.
 */
typedef struct chaincell_contact {
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
     * Area of the triangle at rest that is in contact [m2].
     */
    float area_m2;
    /**
     * The triangle, in the model's order; beyond the last one for the side of a cut.
     */
    uint32_t triangle;
    /**
     * The cell at the corner that takes the largest share; a copy in a wound.
     */
    uint32_t cell;
    /**
     * The cell of the whole body that it is or was made from; `chaincell_model_input_id` has its id.
     */
    uint32_t origin;
    /**
     * The tool, from 0.
     */
    uint32_t tool;
    /**
     * Which of its parts, from 0.
     */
    uint32_t part;
} chaincell_contact;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Version of the library, to compare with `CHAINCELL_VERSION` of the header.
 */
uint32_t chaincell_version(void);

/**
 * A code in words, for logs: a string that is always there. Never null, whatever the number.
 */
const char *chaincell_code_text(int32_t code);

/**
 * Opens `count` faces between tetrahedra, each on both sides, and writes the state of the cuts; `cuts` may be
 * null, and so may `faces` where `count` is 0. The tissue parts there in the next ticks that are not late. An outer
 * face, and one that is open, is left as it is.
 *
 * The tissue was initialised with `cuts` in its room. Between two ticks. Where a face is refused, those before it in
 * the list are open. `detail` may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `faces` are `count` faces, `cuts` is
 * null or storage for the answer, `detail` is null or storage.
 */
chaincell_code chaincell_cut(struct chaincell_tissue *tissue,
                             const struct chaincell_face *faces,
                             size_t count,
                             struct chaincell_cuts *cuts,
                             struct chaincell_detail *detail);

/**
 * The triangles of the surface as it is now: those of the model in its order, at split cells with the copies on which
 * they hang, and behind them the sides of open faces that can part. A triangle of a piece that is gone has three times
 * the same cell. Writes the first `room` of them and says in `count` how many there are; `triangles` may be null where
 * `room` is 0. They change in ticks that open a face or split a cell, and by a restore or a reset.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `triangles` has room for `room` of them,
 * `count` is storage for the answer.
 */
chaincell_code chaincell_triangles(struct chaincell_tissue *tissue,
                                   struct chaincell_triangle *triangles,
                                   size_t room,
                                   size_t *count);

/**
 * Validates a model image in place. Cost: a checksum and about two sweeps, once; no memory.
 *
 * `image` starts at a multiple of 16, has `bytes` bytes, and stays there unchanged for as long as
 * the model or a tissue made from it is in use. Unless the answer is 0 the storage holds no model
 * afterwards. `detail` may be null.
 *
 * Safety
 * `model` is storage for a model, `image` has `bytes` bytes, `detail` is null or storage.
 */
chaincell_code chaincell_model_init(struct chaincell_model *model,
                                    const void *image,
                                    size_t bytes,
                                    struct chaincell_detail *detail);

/**
 * What the model says of itself.
 *
 * Safety
 * `model` is storage for a model, `info` storage for the answer.
 */
chaincell_code chaincell_model_info(const struct chaincell_model *model,
                                    struct chaincell_info *info);

/**
 * The input id of a cell, by its place in arrays of positions.
 *
 * Safety
 * `model` is storage for a model, `input_id` storage for the answer.
 */
chaincell_code chaincell_model_input_id(const struct chaincell_model *model,
                                        uint32_t cell,
                                        uint32_t *input_id);

/**
 * Pins the surface within `radius_m` of a point, 3 numbers, where it is now: its samples there are held in the world
 * by springs of this stiffness in all [N/m]; `INFINITY` makes a rigid pin, 200 times as stiff as tissue of one edge
 * length in depth, on a body of links 10 times. `pin` is its number, the lowest free one.
 *
 * Pinning makes no force. Between two ticks. A pin holds until `chaincell_unpin`, and until a reset or a choice of
 * cells. Tools must have been chosen, on a tissue with room for `pins`; none needs to be engaged. `detail` may be
 * null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `point_m` are three numbers, `pin` is
 * storage for the answer, `detail` is null or storage.
 */
chaincell_code chaincell_pin_at(struct chaincell_tissue *tissue,
                                const float *point_m,
                                float radius_m,
                                float stiffness_n_per_m,
                                uint32_t *pin,
                                struct chaincell_detail *detail);

/**
 * Pins what a tool, from 0, grips, or what it touches if it grips nothing; else as `chaincell_pin_at`. The tool keeps
 * its grip: `chaincell_let_go` frees it, and its pull passes to the pin along that ramp.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `pin` is storage for the answer, `detail`
 * is null or storage.
 */
chaincell_code chaincell_pin_held(struct chaincell_tissue *tissue,
                                  uint32_t tool,
                                  float stiffness_n_per_m,
                                  uint32_t *pin,
                                  struct chaincell_detail *detail);

/**
 * Releases a pin within so many ticks, at most 65,535: its force falls to 0 without a jump, and then it is gone. 0 is
 * as 1.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it.
 */
chaincell_code chaincell_unpin(struct chaincell_tissue *tissue,
                               uint32_t pin,
                               uint32_t ticks);

/**
 * What a pin bears in the published state; `CHAINCELL_CODE_PIN_UNKNOWN` where no pin has this number.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `output` is storage for the answer.
 */
chaincell_code chaincell_pin_force(struct chaincell_tissue *tissue,
                                   uint32_t pin,
                                   struct chaincell_pin_output *output);

/**
 * The defaults for a model and a scheme (one of `chaincell_scheme`): 4 sweeps, nine tenths of the
 * step bound, for rkl2 the time that 4 sweeps cover, one mean link length a tick,
 * prescribed positions, unloading on release, no force limit.
 *
 * Safety
 * `model` is storage for a model, `settings` storage for the answer.
 */
chaincell_code chaincell_settings_default(const struct chaincell_model *model,
                                          int32_t scheme,
                                          chaincell_settings *settings);

/**
 * The settings for a device (one of `chaincell_device`) at 1 kHz whose force acts a tick late:
 * every stage on.
 *
 * Safety
 * `settings` is storage for the answer.
 */
chaincell_code chaincell_stage_default(int32_t device, chaincell_stage_settings *settings);

/**
 * Puts a stage at rest into storage. Unless the answer is 0 there is no stage afterwards.
 *
 * Safety
 * `stage` is storage for a stage, `settings` are settings.
 */
chaincell_code chaincell_stage_init(struct chaincell_stage *stage,
                                    const chaincell_stage_settings *settings);

/**
 * What the tissue is to be given for what the device has measured: the tool behind the coupling.
 * `device` and `tool` may be one pose; the orientation goes through as it is. `news` is null where there
 * are none. A refused call changes nothing.
 *
 * Safety
 * `stage` was made by `chaincell_stage_init` and no other thread uses it; `device` is a pose, `news` is
 * null or news, `tool` is storage for the answer.
 */
chaincell_code chaincell_stage_sample(struct chaincell_stage *stage,
                                      const struct chaincell_tool_pose *device,
                                      const struct chaincell_stage_news *news,
                                      struct chaincell_tool_pose *tool);

/**
 * What the device is given for what the tissue has answered to the tool of
 * `chaincell_stage_sample`; a torque goes along the force's ramp. `tissue` and `output` may be one output.
 * A null `tissue` is a tick without a sample, in which the tissue has no tick either.
 *
 * A tissue under a current tells neither work nor stiffness: a stage with coupling or passivity
 * control then gives force 0 with `CHAINCELL_FLAG_SAFE_STATE`.
 *
 * Where a pointer is bad the stage stays as it is, and an `output` that can be written says the
 * same.
 *
 * Safety
 * `stage` was made by `chaincell_stage_init` and no other thread uses it; `tissue` is null or an output,
 * `output` is storage for the answer.
 */
chaincell_code chaincell_stage_output(struct chaincell_stage *stage,
                                      const struct chaincell_output *tissue,
                                      struct chaincell_output *output);

/**
 * Saves all that the stage knows but its settings into `bytes` bytes at `snapshot`; `written` says how
 * many it took and may be null. A null `snapshot` of 0 bytes asks how many it would take.
 *
 * Safety
 * `stage` was made by `chaincell_stage_init` and no other thread uses it; `snapshot` is storage of `bytes`
 * bytes, `written` is null or storage for the answer.
 */
chaincell_code chaincell_stage_save(struct chaincell_stage *stage,
                                    uint8_t *snapshot,
                                    size_t bytes,
                                    size_t *written);

/**
 * Goes on from a stage's snapshot: with the same settings, samples and answers to the same forces. A
 * snapshot that is refused changes nothing.
 *
 * Safety
 * `stage` was made by `chaincell_stage_init` and no other thread uses it; `snapshot` points to `bytes`
 * bytes.
 */
chaincell_code chaincell_stage_restore(struct chaincell_stage *stage,
                                       const uint8_t *snapshot,
                                       size_t bytes);

/**
 * Bytes of a tissue for this model with this room, and what multiple of bytes its storage starts at:
 * `CHAINCELL_ALIGN`, or `CHAINCELL_SHAPE_ALIGN` for a body of nodal shapes and with room for tools on a
 * surface. `bytes` or `align` may be null.
 *
 * Safety
 * `model` is storage for a model, `room` is a room; `bytes` and `align` are null or storage for the
 * answers.
 */
chaincell_code chaincell_model_size(const struct chaincell_model *model,
                                    int32_t scheme,
                                    const struct chaincell_room *room,
                                    size_t *bytes,
                                    size_t *align);

/**
 * Puts a body at rest into storage, with this room, and no contacts chosen yet; room for tools under track
 * and predict alone.
 *
 * `storage` starts at a multiple of what `chaincell_model_size` says, and has `bytes` bytes, at least as
 * many as it says; what stood there is lost, also where the call is refused. `scheme` is one of
 * `chaincell_scheme`. The answer in `tissue` is the address of the storage, or null. Model and settings
 * are copied; the model's image is not. `detail` may be null. Cost: clears the storage.
 *
 * Safety
 * `storage` has `bytes` bytes which nobody else uses as long as the tissue is in use, nor do they
 * overlap the other arguments or the image; `model` is storage for a model, `room` is a room, `settings`
 * are settings, `tissue` is storage for an address, `detail` is null or storage.
 */
chaincell_code chaincell_tissue_init(void *storage,
                                     size_t bytes,
                                     const struct chaincell_model *model,
                                     int32_t scheme,
                                     const struct chaincell_room *room,
                                     const chaincell_settings *settings,
                                     struct chaincell_tissue **tissue,
                                     struct chaincell_detail *detail);

/**
 * Back to rest: the tool released, no contact cells chosen.
 *
 * Refused where the calling thread's arithmetic is not IEEE 754 to nearest; the body then stays
 * as it is. `detail` may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `detail` is null or
 * storage.
 */
chaincell_code chaincell_tissue_reset(struct chaincell_tissue *tissue,
                                      struct chaincell_detail *detail);

/**
 * Saves all that the tissue knows but its settings, between two ticks, into `bytes` bytes at `snapshot`;
 * `written` says how many it took and may be null. The tissue does not change. Cost: that of copying the
 * tissue, twice over, and a checksum.
 *
 * A null `snapshot` of 0 bytes asks how many it would take now, which depends on the model, on what was
 * chosen to touch it, and on the triangles in reach. `detail` may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `snapshot` is storage of
 * `bytes` bytes, `written` is null or storage for the answer, `detail` is null or storage.
 */
chaincell_code chaincell_tissue_save(struct chaincell_tissue *tissue,
                                     uint8_t *snapshot,
                                     size_t bytes,
                                     size_t *written,
                                     struct chaincell_detail *detail);

/**
 * Goes on from a snapshot of the same model under the same scheme: with the same settings and samples
 * to the same hashes and forces, whatever the processor. The tissue has room for what the saved one
 * had in use. A snapshot that is refused changes nothing. `detail` may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `snapshot` points to `bytes`
 * bytes, `detail` is null or storage.
 */
chaincell_code chaincell_tissue_restore(struct chaincell_tissue *tissue,
                                        const uint8_t *snapshot,
                                        size_t bytes,
                                        struct chaincell_detail *detail);

/**
 * Changes the settings from the next tick on; the body stays as it is. `detail` may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `settings` are
 * settings, `detail` is null or storage.
 */
chaincell_code chaincell_change_settings(struct chaincell_tissue *tissue,
                                         const chaincell_settings *settings,
                                         struct chaincell_detail *detail);

/**
 * Chooses the cells that the tool holds while engaged: `count` input ids in any order, none
 * fixed, none twice. None at all is a choice too. A refused choice leaves the old one. Of a model
 * baked with --cells an id stands for the cell of its group: two of one group are one twice.
 *
 * Looks through all cells for each id: not for a tick. `detail` may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `input_ids` are
 * `count` ids, `detail` is null or storage.
 */
chaincell_code chaincell_choose_contacts(struct chaincell_tissue *tissue,
                                         const uint32_t *input_ids,
                                         size_t count,
                                         struct chaincell_detail *detail);

/**
 * Strain and stress at the cell of a node of the input mesh, by its id, at the published positions. The mean stress is
 * that of the cell and of those linked to it. A body of links has none: `CHAINCELL_CODE_NO_STRESS`. A tick computes
 * nothing of it. Cost: some thousand operations for each of these cells, and a look through all cells for the id.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `stress` is storage for the answer.
 */
chaincell_code chaincell_stress(struct chaincell_tissue *tissue,
                                uint32_t input_id,
                                struct chaincell_cell_stress *stress);

/**
 * One tick with a pose for each tool, and an answer to each in `outputs`: infallible with good pointers,
 * and with a number of link passes that is bounded whatever the poses say. Bad samples are held for
 * up to 10 ticks, then the safe state answers.
 *
 * `count` is 1, or up to as many tools as the tissue has room for, best as many as were chosen. Tools
 * beyond the poses stay as they are; but all let go where no pose is engaged. One bad pose makes the
 * sample a bad one. A null `budget` stands for all sweeps of the settings; `outputs->sweeps` says how
 * many were made, and the level is certified after every one. A single output has the work of all tools.
 *
 * Where a pointer is bad nothing moves, and `outputs` that can be written say force 0 with
 * `CHAINCELL_FLAG_SAFE_STATE`. The calling thread's arithmetic is that of the last reset.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `poses` are `count` poses,
 * `budget` is null or a budget, whose `more` is null or may be called with its `context` and does not
 * touch the tissue; `outputs` is storage for `count` answers.
 */
chaincell_code chaincell_tick(struct chaincell_tissue *tissue,
                              const struct chaincell_tool_pose *poses,
                              size_t count,
                              const struct chaincell_budget *budget,
                              struct chaincell_output *outputs);

/**
 * The state hash: 64 bits over the published positions of all cells, over their shapes where they have
 * any, and over the cuts of a body that is cut; the same on every target.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread writes it; `hash` is storage
 * for the answer.
 */
chaincell_code chaincell_state_hash(const struct chaincell_tissue *tissue,
                                    uint64_t *hash);

/**
 * Published position of a node of the input mesh, by its id, in the frame of the input mesh [m]: of a
 * model baked with --cells and without --lean from the cells around the node, of others that of the
 * node's cell. Cost: the node's weights, or a look through all cells for the id.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread writes it; `position_m` is
 * storage for the answer.
 */
chaincell_code chaincell_position(const struct chaincell_tissue *tissue,
                                  uint32_t input_id,
                                  float (*position_m)[3]);

/**
 * Published positions of all cells, x, y, z of each in the model's order (`chaincell_model_input_id`)
 * [mean link lengths from the body's centre]: bit by bit what `chaincell_set_positions` takes.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread writes it; `positions` has room
 * for 3 `cells` numbers.
 */
chaincell_code chaincell_positions(const struct chaincell_tissue *tissue,
                                   float *positions,
                                   size_t cells);

/**
 * Puts every cell, fixed ones too, at a position, without motion and with the tool released; the
 * contact cells stay chosen. Order and unit are those of `chaincell_positions`. A refused state
 * changes nothing. `detail` may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `positions` are 3
 * `cells` numbers, `detail` is null or storage.
 */
chaincell_code chaincell_set_positions(struct chaincell_tissue *tissue,
                                       const float *positions,
                                       size_t cells,
                                       struct chaincell_detail *detail);

/**
 * Gives the tissue tools on the model's surface in place of chosen cells: `tools` of them, tool i of
 * `counts[i]` parts, 1 to 8; `parts` has those of the first tool, then those of the second and so on.
 * `friction` is the coefficient of all by Coulomb's law, 0 to 10.
 *
 * The model has a contact surface, the tissue was initialised by `chaincell_tissue_init` with room for so
 * many tools, and for samples where there is friction.
 * The lists are copied. Refused while a tool is engaged; a refused choice leaves the old one. `detail`
 * may be null.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `counts` are `tools` numbers, `parts` as
 * many parts as they say, `detail` is null or storage.
 */
chaincell_code chaincell_choose_tools(struct chaincell_tissue *tissue,
                                      const struct chaincell_tool_part *parts,
                                      const uint32_t *counts,
                                      size_t tools,
                                      float friction,
                                      struct chaincell_detail *detail);

/**
 * The contacts of all tools in the last tick, one for each triangle and part of a tool: writes the first
 * `room` of them and says in `count` how many there are. `contacts` may be null where `room` is 0.
 *
 * Cost: one look at the samples in reach.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `contacts` has room for
 * `room` of them, `count` is storage for the answer.
 */
chaincell_code chaincell_contact_forces(struct chaincell_tissue *tissue,
                                        struct chaincell_contact *contacts,
                                        size_t room,
                                        size_t *count);

/**
 * A tool, from 0, grips what it is in contact with: it holds these samples where they are in its frame,
 * without slip, until `chaincell_let_go` or until it is no longer engaged. A tool that stays is a pin.
 * `samples` says how many it holds, 0 where it touches nothing; it may be null.
 *
 * The force does not jump: a grip begins without pull. Between two ticks. The tissue must have room for
 * samples.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `samples` is null or
 * storage for the answer.
 */
chaincell_code chaincell_grip(struct chaincell_tissue *tissue,
                              uint32_t tool,
                              size_t *samples);

/**
 * A tool, from 0, lets go of what it grips, within so many ticks, at most 65,535: the pull falls to 0
 * evenly. 0 is as 1.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it.
 */
chaincell_code chaincell_let_go(struct chaincell_tissue *tissue,
                                uint32_t tool,
                                uint32_t ticks);

/**
 * Torque of the tissue on the handles of the scissors of a tool, from 0, about their pivot in the last tick with a
 * sweep [N m]: above 0 it resists closing. 0 for a tool without scissors. No limit clamps it.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `torque_n_m` is storage for
 * the answer.
 */
chaincell_code chaincell_opening_torque(struct chaincell_tissue *tissue,
                                        uint32_t tool,
                                        float *torque_n_m);

/**
 * Samples that a tool, from 0, grips.
 *
 * Safety
 * `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `samples` is storage for
 * the answer.
 */
chaincell_code chaincell_gripped(struct chaincell_tissue *tissue,
                                 uint32_t tool,
                                 size_t *samples);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CHAINCELL_H */
