#ifndef METABUFFER_HOST_H
#define METABUFFER_HOST_H

/*
 * The host's side of a Metabuffer in C99, for applications: what a renderer's computer writes into the frames of its
 * link (sections 4 and 5 of the paper), and the connection to a wall that `metabuffer live` simulates.
 *
 * A function that can fail returns a metabuffer_status; METABUFFER_OK is 0. Nothing here ends the process, prints,
 * installs a signal handler or keeps a global state. Different links may be used by different threads at once, one link
 * by one thread at a time. Memory that a caller hands over stays the caller's.
 *
 * A link pixel is 24 bits in a 32-bit word: 0xRRGGBB of a colour frame; of a depth frame what its depth format says.
 */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum metabuffer_status {
    METABUFFER_OK = 0,
    METABUFFER_BAD_ARGUMENT, /* null, or outside of the range that the function names */
    METABUFFER_NO_ROOM,      /* the result does not fit what the caller or the scanline has room for */
    METABUFFER_BAD_MULTIPLE, /* a viewport's multiple is not 1 to 255 */
    METABUFFER_BAD_POSITION, /* a coordinate of a row does not fit its 16-bit field */
    METABUFFER_BAD_MAGIC,    /* a control scanline does not begin with MBUF */
    METABUFFER_BAD_VERSION,  /* its version is another one */
    METABUFFER_BAD_CRC,      /* its CRC or one of its counts is wrong */
    METABUFFER_BAD_KIND,     /* its kind is neither colour nor depth */
    METABUFFER_BAD_SLOTS,    /* a payload is not a slot table */
    METABUFFER_NO_WALL,      /* nobody listens at the socket */
    METABUFFER_REFUSED,      /* the wall has refused the link; metabuffer_link_message says why */
    METABUFFER_ENDED,        /* the wall has ended */
    METABUFFER_TIMEOUT,      /* nothing has come in the time given */
    METABUFFER_SYSTEM,       /* the system has refused a socket or memory; errno says why */
    METABUFFER_STATUS_COUNT
} metabuffer_status;

/* A sentence without a full stop: "the wall has ended". For an unknown status one that says so. */
const char* metabuffer_status_text(metabuffer_status status);

/* ---- viewport table (section 5) ---- */

/* Where an image lies in the joint display space: the raster position of its top left pixel, which may be anywhere, and
 * the raster pixels that each of its pixels covers in x and in y, 1 to 255. */
typedef struct metabuffer_viewport {
    int32_t x;
    int32_t y;
    int32_t multiple;
} metabuffer_viewport;

/* The joint display space: a grid of equal rasters, numbered from 1, row by row. */
typedef struct metabuffer_wall {
    int32_t columns;
    int32_t rows;
    int32_t raster_width_pixels; /* of one display, supersampling included */
    int32_t raster_height_pixels;
    int32_t gap_x_pixels; /* raster pixels between neighbours that nobody sees */
    int32_t gap_y_pixels;
    int32_t smooths; /* not 0: composers mix neighbouring pixels of a magnified image */
} metabuffer_wall;

/* A row of the table: which rectangle of the image goes to which display, and where in its raster. */
typedef struct metabuffer_row {
    uint16_t dcomp; /* display, from 1 */
    uint16_t sx;    /* the rectangle in image pixels; sy = 0 is the first scanline of the image, its top */
    uint16_t sy;
    uint16_t sdx;
    uint16_t sdy;
    int16_t dx; /* raster position of its top left */
    int16_t dy;
    uint16_t dmultiple;
} metabuffer_row;

/* Writes the rows that show an image at a viewport, one for each display that it touches, in the order of the displays.
 * rows: room for `capacity` of them; columns * rows of the wall are always enough. *count: how many there are, also with
 * METABUFFER_NO_ROOM, BAD_MULTIPLE and BAD_POSITION excepted. An image that no display shows has none. */
metabuffer_status metabuffer_split_viewport(const metabuffer_viewport* viewport, int32_t image_width_pixels,
                                            int32_t image_height_pixels, const metabuffer_wall* wall,
                                            metabuffer_row* rows, size_t capacity, size_t* count);

/* ---- slot table (sections 5.1 and 5.3), for machines in which the host makes it ---- */

/* The largest payload there is, and the most slots. */
#define METABUFFER_PAYLOAD_BYTES 65535
#define METABUFFER_SLOTS 65535

/* Writes the slots of idle-recovery slot allocation: a slot is the index of a row, from 0; each row has slots in
 * proportion to sdx / dmultiple, at least one. rows: with sdx of 1 or more and dmultiple of 1 to 255. limit: the most
 * slots that are in exact proportion, 1 to 256. *count: at most limit + row_count, also with METABUFFER_NO_ROOM. */
metabuffer_status metabuffer_make_slots(const metabuffer_row* rows, size_t row_count, size_t limit,
                                        uint16_t* slots, size_t capacity, size_t* count);

/* How many slots of a table of that many rows fit into a payload of that many bytes. */
size_t metabuffer_slots_in_payload(size_t payload_bytes, size_t row_count);

/* Slots to a payload and back. row_count: 1 to 65536, more than any slot. *bytes and *count: what was written. */
metabuffer_status metabuffer_write_slots(const uint16_t* slots, size_t count, size_t row_count,
                                         uint8_t* payload, size_t capacity, size_t* bytes);
metabuffer_status metabuffer_read_slots(const uint8_t* payload, size_t bytes, uint16_t* slots,
                                        size_t capacity, size_t* count);

/* ---- control scanline (section 4): the first line of every frame, which is never displayed ---- */

typedef enum metabuffer_frame_kind { METABUFFER_COLOUR = 0, METABUFFER_DEPTH = 1 } metabuffer_frame_kind;

/* What a control scanline says. The colour frame's table is the one that counts; a slot table is the depth frame's
 * payload. */
typedef struct metabuffer_control {
    uint8_t kind;          /* metabuffer_frame_kind */
    uint32_t frame_number; /* the same in both frames of a pair; after 0xFFFFFFFF comes 0 */
    const metabuffer_row* rows;
    size_t row_count; /* at most 65535 */
    const uint8_t* payload;
    size_t payload_bytes; /* at most 65535 */
} metabuffer_control;

/* Bytes that the content takes; a scanline has three for each of its pixels. */
size_t metabuffer_control_bytes(size_t row_count, size_t payload_bytes);

/* Writes the scanline, CRC included, and zeros after it. METABUFFER_NO_ROOM: it does not fit width_pixels. */
metabuffer_status metabuffer_write_control(const metabuffer_control* control, uint32_t* scanline,
                                           size_t width_pixels);

/* Reads and checks a scanline, in the order magic, version, CRC, kind. *control then refers to `rows` and `payload`, which
 * have room for as much as their capacities say; with capacities of 0 and without control it only checks. */
metabuffer_status metabuffer_read_control(const uint32_t* scanline, size_t width_pixels,
                                          metabuffer_control* control, metabuffer_row* rows,
                                          size_t row_capacity, uint8_t* payload, size_t payload_capacity);

/* ---- depth ---- */

typedef enum metabuffer_depth_format {
    METABUFFER_ANY_DEPTH = -1, /* to open a link: whichever the wall has */
    METABUFFER_A8Z16 = 0,      /* alpha in bits 23 to 16, Z in bits 15 to 0 */
    METABUFFER_Z24 = 1         /* Z in bits 23 to 0, no alpha */
} metabuffer_depth_format;

typedef enum metabuffer_depth_type {
    METABUFFER_DEPTH_FLOAT = 0, /* float, 0 near, 1 far; clamped, and what is no number is far */
    METABUFFER_DEPTH_UINT16,    /* uint16_t, all ones is far */
    METABUFFER_DEPTH_UINT24,    /* uint32_t whose lower 24 bits are the depth */
    METABUFFER_DEPTH_UINT32     /* uint32_t, all ones is far */
} metabuffer_depth_type;

/* Link pixels of a depth frame from `count` depths, rounded to nearest. Z 0 is nearest. reversed: not 0 if the
 * depth's larger values are nearer. alpha: one byte a pixel, `alpha_stride` bytes apart; or null for 255. */
metabuffer_status metabuffer_pack_depth(metabuffer_depth_format format, metabuffer_depth_type type,
                                        const void* depths, size_t count, int reversed, const uint8_t* alpha,
                                        size_t alpha_stride, uint32_t* link_pixels);

/* Link pixels of a colour frame from R, G, B, which are the first bytes of every `stride` bytes, 3 or more. */
metabuffer_status metabuffer_pack_colour(const uint8_t* rgb, size_t stride, size_t count,
                                         uint32_t* link_pixels);

/* ---- connection ---- */

/* The link of one renderer to a wall that `metabuffer live` simulates. */
typedef struct metabuffer_link metabuffer_link;

/* Which slot table a machine wants in each depth frame. */
typedef enum metabuffer_slots_wanted {
    METABUFFER_NO_SLOTS = 0,           /* none: the machine makes its own, or its arbitration has none */
    METABUFFER_PROPORTIONAL_SLOTS = 1, /* that of metabuffer_make_slots */
    METABUFFER_EQUAL_SLOTS = 2         /* one slot for each row, in their order */
} metabuffer_slots_wanted;

/* What the wall says of itself and of the link when it accepts it. */
typedef struct metabuffer_link_info {
    metabuffer_wall wall;
    metabuffer_depth_format depth_format;
    int32_t image_width_pixels; /* without the control scanline */
    int32_t image_height_pixels;
    int32_t lockstep;      /* not 0: composited frame k is made of pair k; 0: of the newest pair */
    int32_t slots_wanted;  /* metabuffer_slots_wanted */
    int32_t buffer_pixels; /* of one composer */
    int32_t ready_space_pixels;
} metabuffer_link_info;

/* A pair of frames to be filled: lines of image_width_pixels link pixels, of which the first is the control scanline. Its
 * memory is shared with the wall, and the application's until it is submitted. */
typedef struct metabuffer_pair {
    uint32_t* colour;
    uint32_t* depth;
    uint32_t frame_number; /* what both control scanlines have to say */
    uint32_t index;        /* the library's */
} metabuffer_pair;

/* Room for every socket's path. */
#define METABUFFER_PATH_BYTES 108

/* The path of the socket at which a wall of that name listens unless it is told otherwise:
 * $XDG_RUNTIME_DIR/metabuffer-NAME.sock, without that variable /tmp/metabuffer-UID-NAME.sock. */
metabuffer_status metabuffer_default_socket(const char* wall_name, char* path, size_t capacity);

/* Connects the renderer `link_name` of the scenario, which must be a live one that nobody has connected. Sizes are those
 * of the image and must be the scenario's; 0 and 0 take what the scenario says. So must the depth format be. timeout_ms: for the wall's answer; below
 * 0 for ever. *link: to be closed, also if the status is METABUFFER_REFUSED; null for any other failure. */
metabuffer_status metabuffer_open_link(const char* socket_path, const char* link_name,
                                       int32_t image_width_pixels, int32_t image_height_pixels,
                                       metabuffer_depth_format depth_format, int timeout_ms,
                                       metabuffer_link** link);

/* One line, the wall's words: why it has refused or ended the link; empty if it has not. The link's. */
const char* metabuffer_link_message(const metabuffer_link* link);
const metabuffer_link_info* metabuffer_link_get_info(const metabuffer_link* link);

/* Waits until a pair is free and hands it out. At most `timeout_ms` milliseconds; below 0 for ever. */
metabuffer_status metabuffer_begin_pair(metabuffer_link* link, int timeout_ms, metabuffer_pair* pair);

/* Writes both control scanlines of a pair: the table, and the slot table if the wall wants it. */
metabuffer_status metabuffer_write_controls(const metabuffer_link* link, const metabuffer_pair* pair,
                                            const metabuffer_row* rows, size_t row_count);

/* Hands the pair to the wall. Pairs are submitted in the order in which they were begun. */
metabuffer_status metabuffer_submit_pair(metabuffer_link* link, const metabuffer_pair* pair);

/* Closes the link: its renderer falls silent. Null is allowed. */
void metabuffer_close_link(metabuffer_link* link);

#ifdef __cplusplus
}
#endif

#endif
