#ifndef METABUFFER_LIVE_PROTOCOL_H
#define METABUFFER_LIVE_PROTOCOL_H

/*
 * What an application and `metabuffer live` say to each other over their Unix stream socket: structures of fixed size in
 * the computer's byte order, both ends being on one computer.
 *
 * | who | says | when |
 * | --- | --- | --- |
 * | application | live_hello | first |
 * | wall | live_welcome, and with it the descriptor of the shared memory if it accepts | at the next pair it asks for |
 * | wall | live_grant | when a pair of the ring is free: at first each, later each that it has taken over |
 * | application | live_submission | when it has filled the pair of the oldest grant |
 * | either | end of the stream | when it wants no more |
 *
 * The memory is the wall's, and sealed: its size is fixed. Pair i of the ring is the colour frame, then the depth frame,
 * of (image height + 1) lines of (image width) words, one for each link pixel.
 */

#include "application/metabuffer_host.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LIVE_MAGIC 0x564C424DU /* "MBLV" */
#define LIVE_VERSION 1U
#define LIVE_NAME_BYTES 128
#define LIVE_MESSAGE_BYTES 256
#define LIVE_RING_PAIRS 3

typedef struct live_hello {
    uint32_t magic;
    uint32_t version;
    char link_name[LIVE_NAME_BYTES]; /* ends with a zero */
    int32_t image_width_pixels;      /* 0: any */
    int32_t image_height_pixels;
    int32_t depth_format; /* metabuffer_depth_format; METABUFFER_ANY_DEPTH: any */
} live_hello;

typedef struct live_welcome {
    uint32_t magic;
    uint32_t version;
    uint32_t accepted;                /* 0: the message says why not, and the stream ends */
    char message[LIVE_MESSAGE_BYTES]; /* ends with a zero */
    metabuffer_link_info info;
} live_welcome;

typedef struct live_grant {
    uint32_t index;        /* of a pair in the ring */
    uint32_t frame_number; /* that its control scanlines have to say */
} live_grant;

typedef live_grant live_submission;

/* Words of a frame, and bytes of the ring. */
static inline size_t live_frame_words(int32_t image_width_pixels, int32_t image_height_pixels) {
    return (size_t)image_width_pixels * ((size_t)image_height_pixels + 1);
}
static inline size_t live_ring_bytes(int32_t image_width_pixels, int32_t image_height_pixels) {
    return (size_t)LIVE_RING_PAIRS * 2 * live_frame_words(image_width_pixels, image_height_pixels) *
           sizeof(uint32_t);
}

#ifdef __cplusplus
}
#endif

#endif
