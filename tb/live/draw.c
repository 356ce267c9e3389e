/* An application in C99: submits pairs whose pixels depend on the pair's number, the pixel's position and a tint.
 *
 * usage: draw SOCKET LINK PAIRS X,Y,MULTIPLE TINT MILLISECONDS
 * MILLISECONDS is the time between two pairs. -1: none, and each pair's memory is drawn once, so that the wall alone is
 * measured.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "metabuffer_host.h"

enum { WAIT_MS = 20000, MOST_DISPLAYS = 16 };

static int fail(const metabuffer_link* link, metabuffer_status status) {
    const char* const message = metabuffer_link_message(link);
    fprintf(stderr, "draw: %s\n", message[0] != '\0' ? message : metabuffer_status_text(status));
    return (int)status;
}

static void draw(const metabuffer_link_info* info, const metabuffer_pair* pair, uint32_t tint) {
    for (int32_t y = 0; y < info->image_height_pixels; ++y) {
        uint32_t* const colours = pair->colour + (size_t)(y + 1) * (size_t)info->image_width_pixels;
        uint32_t* const depths = pair->depth + (size_t)(y + 1) * (size_t)info->image_width_pixels;
        for (int32_t x = 0; x < info->image_width_pixels; ++x) {
            const uint32_t step = (uint32_t)x * 7 + (uint32_t)y * 13 + pair->frame_number * 29;
            const uint8_t rgb[3] = {(uint8_t)step, (uint8_t)(step >> 8), (uint8_t)tint};
            const uint32_t depth = step * 0x9E3779B9U + tint;
            metabuffer_pack_colour(rgb, sizeof rgb, 1, &colours[x]);
            metabuffer_pack_depth(info->depth_format, METABUFFER_DEPTH_UINT32, &depth, 1, 0, NULL, 0,
                                  &depths[x]);
        }
    }
}

int main(int count, char** words) {
    if (count != 7) return 1;
    metabuffer_viewport viewport;
    if (sscanf(words[4], "%d,%d,%d", &viewport.x, &viewport.y, &viewport.multiple) != 3) return 1;
    const long milliseconds = atol(words[6]);
    metabuffer_link* link = NULL;
    metabuffer_status status =
        metabuffer_open_link(words[1], words[2], 0, 0, METABUFFER_ANY_DEPTH, WAIT_MS, &link);
    if (status == METABUFFER_OK) {
        const metabuffer_link_info* const info = metabuffer_link_get_info(link);
        metabuffer_row rows[MOST_DISPLAYS];
        size_t row_count = 0;
        uint32_t drawn = 0; /* by memory of the ring */
        status = metabuffer_split_viewport(&viewport, info->image_width_pixels, info->image_height_pixels,
                                           &info->wall, rows, MOST_DISPLAYS, &row_count);
        for (long n = atol(words[3]); n > 0 && status == METABUFFER_OK; --n) {
            metabuffer_pair pair;
            status = metabuffer_begin_pair(link, WAIT_MS, &pair);
            if (status != METABUFFER_OK) break;
            if (milliseconds >= 0 || (drawn >> pair.index & 1U) == 0) {
                draw(info, &pair, (uint32_t)atol(words[5]));
                drawn |= 1U << pair.index;
            }
            status = metabuffer_write_controls(link, &pair, rows, row_count);
            if (status == METABUFFER_OK) status = metabuffer_submit_pair(link, &pair);
            if (milliseconds <= 0) continue;
            const struct timespec pause = {milliseconds / 1000, milliseconds % 1000 * 1000000};
            nanosleep(&pause, NULL);
        }
    }
    const int result = status == METABUFFER_OK ? 0 : fail(link, status);
    metabuffer_close_link(link);
    return result;
}
