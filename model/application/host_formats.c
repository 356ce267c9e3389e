#include <stdlib.h>
#include <string.h>

#include "application/metabuffer_host.h"

enum {
    CONTROL_VERSION = 1,
    VERSION_OFFSET = 4,
    KIND_OFFSET = 5,
    ROW_COUNT_OFFSET = 6,
    NUMBER_OFFSET = 8,
    CRC_OFFSET = 12,
    HEADER_BYTES = 16,
    ROW_BYTES = 16,
    LENGTH_BYTES = 2,
    PIXEL_BYTES = 3,
    LARGEST_COUNT = 65535,
    LARGEST_MULTIPLE = 255,
    SLOT_HEADER_BYTES = 4,
    SLOT_MARK = 'S',
    MOST_SLOT_BITS = 16,
    MOST_SLOT_LIMIT = 256
};

static const char kMagic[4] = {'M', 'B', 'U', 'F'};

const char* metabuffer_status_text(metabuffer_status status) {
    switch (status) {
        case METABUFFER_OK:
            return "done";
        case METABUFFER_BAD_ARGUMENT:
            return "an argument is null or outside of its range";
        case METABUFFER_NO_ROOM:
            return "the result does not fit the room there is for it";
        case METABUFFER_BAD_MULTIPLE:
            return "the viewport's multiple is outside 1 to 255";
        case METABUFFER_BAD_POSITION:
            return "the image lies so far outside that a coordinate does not fit 16 bits";
        case METABUFFER_BAD_MAGIC:
            return "the control scanline does not begin with MBUF";
        case METABUFFER_BAD_VERSION:
            return "the control scanline's version is not 1";
        case METABUFFER_BAD_CRC:
            return "the control scanline's CRC or one of its counts is wrong";
        case METABUFFER_BAD_KIND:
            return "the control scanline's kind is neither colour nor depth";
        case METABUFFER_BAD_SLOTS:
            return "the payload is not a slot table";
        case METABUFFER_NO_WALL:
            return "no wall listens at the socket";
        case METABUFFER_REFUSED:
            return "the wall has refused the link";
        case METABUFFER_ENDED:
            return "the wall has ended";
        case METABUFFER_TIMEOUT:
            return "the wall has not answered in time";
        case METABUFFER_SYSTEM:
            return "the system has refused a socket or memory";
        case METABUFFER_STATUS_COUNT:
            break;
    }
    return "there is no such status";
}

/* ---- viewport table ---- */

static int64_t floor_div(int64_t dividend, int64_t divisor) {
    const int64_t quotient = dividend / divisor;
    return dividend % divisor < 0 ? quotient - 1 : quotient;
}

static int64_t larger(int64_t a, int64_t b) { return a > b ? a : b; }
static int64_t smaller(int64_t a, int64_t b) { return a < b ? a : b; }

/* Of one axis: the source pixels that one display shows, and the raster position of the first. */
typedef struct Span {
    int64_t first;
    int64_t count;
    int64_t destination;
} Span;

/* position: of the image's first pixel relative to the display's; apron: pixels more on each side. */
static Span visible_span(int64_t position, int64_t multiple, int64_t image, int64_t raster, int64_t apron) {
    int64_t first = larger(0, floor_div(-position, multiple));
    int64_t last = smaller(image - 1, floor_div(raster - 1 - position, multiple));
    Span span = {0, 0, 0};
    if (first > last) return span;
    first = larger(0, first - apron);
    last = smaller(image - 1, last + apron);
    span.first = first;
    span.count = last - first + 1;
    span.destination = position + first * multiple;
    return span;
}

static int fits_unsigned(int64_t value) { return value >= 0 && value <= UINT16_MAX; }
static int fits_signed(int64_t value) { return value >= INT16_MIN && value <= INT16_MAX; }

static metabuffer_status make_row(int64_t display, Span x, Span y, int32_t multiple, metabuffer_row* row) {
    if (!fits_unsigned(display) || !fits_unsigned(x.first) || !fits_unsigned(y.first) ||
        !fits_unsigned(x.count) || !fits_unsigned(y.count) || !fits_signed(x.destination) ||
        !fits_signed(y.destination)) {
        return METABUFFER_BAD_POSITION;
    }
    row->dcomp = (uint16_t)display;
    row->sx = (uint16_t)x.first;
    row->sy = (uint16_t)y.first;
    row->sdx = (uint16_t)x.count;
    row->sdy = (uint16_t)y.count;
    row->dx = (int16_t)x.destination;
    row->dy = (int16_t)y.destination;
    row->dmultiple = (uint16_t)multiple;
    return METABUFFER_OK;
}

metabuffer_status metabuffer_split_viewport(const metabuffer_viewport* viewport, int32_t image_width_pixels,
                                            int32_t image_height_pixels, const metabuffer_wall* wall,
                                            metabuffer_row* rows, size_t capacity, size_t* count) {
    if (viewport == NULL || wall == NULL || count == NULL || (rows == NULL && capacity > 0) ||
        image_width_pixels < 1 || image_height_pixels < 1 || wall->columns < 1 || wall->rows < 1 ||
        wall->raster_width_pixels < 1 || wall->raster_height_pixels < 1 || wall->gap_x_pixels < 0 ||
        wall->gap_y_pixels < 0) {
        return METABUFFER_BAD_ARGUMENT;
    }
    if (viewport->multiple < 1 || viewport->multiple > LARGEST_MULTIPLE) return METABUFFER_BAD_MULTIPLE;
    const int64_t pitch_x = (int64_t)wall->raster_width_pixels + wall->gap_x_pixels;
    const int64_t pitch_y = (int64_t)wall->raster_height_pixels + wall->gap_y_pixels;
    const int64_t apron = wall->smooths != 0 && viewport->multiple > 1 ? 1 : 0;
    size_t made = 0;
    for (int32_t line = 0; line < wall->rows; ++line) {
        const Span y = visible_span(viewport->y - line * pitch_y, viewport->multiple, image_height_pixels,
                                    wall->raster_height_pixels, apron);
        for (int32_t column = 0; column < wall->columns; ++column) {
            const Span x = visible_span(viewport->x - column * pitch_x, viewport->multiple,
                                        image_width_pixels, wall->raster_width_pixels, apron);
            if (x.count == 0 || y.count == 0) continue;
            metabuffer_row row;
            const metabuffer_status status =
                make_row((int64_t)line * wall->columns + column + 1, x, y, viewport->multiple, &row);
            if (status != METABUFFER_OK) return status;
            if (made < capacity) rows[made] = row;
            ++made;
        }
    }
    *count = made;
    return made <= capacity ? METABUFFER_OK : METABUFFER_NO_ROOM;
}

/* ---- slot table ---- */

static uint64_t greatest_divisor(uint64_t a, uint64_t b) {
    while (b != 0) {
        const uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* What makes every 1 / dmultiple a whole number; where that is too large, nearly one. */
static uint64_t weight_scale(const metabuffer_row* rows, size_t row_count) {
    const uint64_t largest = (uint64_t)1 << 32, otherwise = (uint64_t)1 << 20;
    uint64_t scale = 1;
    for (size_t i = 0; i < row_count; ++i) {
        scale = scale / greatest_divisor(scale, rows[i].dmultiple) * rows[i].dmultiple;
        if (scale > largest) return otherwise;
    }
    return scale;
}

/* What a row has and is owed while slots are dealt out. */
typedef struct Share {
    int64_t slots;
    int64_t credit;
} Share;

/* Smooth weighted round robin: in every slot each row earns its share of credit; the richest gets the slot and pays the
 * sum of all shares. */
static void deal_slots(Share* shares, size_t row_count, int64_t total, uint16_t* slots) {
    for (int64_t slot = 0; slot < total; ++slot) {
        size_t richest = 0;
        for (size_t i = 0; i < row_count; ++i) {
            shares[i].credit += shares[i].slots;
            if (shares[i].credit > shares[richest].credit) richest = i;
        }
        shares[richest].credit -= total;
        slots[slot] = (uint16_t)richest;
    }
}

/* The slots of each row, in exact proportion if that takes at most `limit`; returns their sum. */
static int64_t share_slots(const metabuffer_row* rows, size_t row_count, int64_t limit, Share* shares) {
    const int64_t scale = (int64_t)weight_scale(rows, row_count);
    uint64_t divisor = 0;
    for (size_t i = 0; i < row_count; ++i) {
        shares[i].slots = rows[i].sdx * scale / rows[i].dmultiple;
        divisor = greatest_divisor(divisor, (uint64_t)shares[i].slots);
    }
    int64_t sum = 0;
    for (size_t i = 0; i < row_count; ++i) sum += shares[i].slots /= (int64_t)divisor;
    if (sum <= limit) return sum;
    int64_t total = 0;
    for (size_t i = 0; i < row_count; ++i) {
        const int64_t rounded = (2 * shares[i].slots * limit + sum) / (2 * sum);
        total += shares[i].slots = larger(1, rounded);
    }
    return total;
}

metabuffer_status metabuffer_make_slots(const metabuffer_row* rows, size_t row_count, size_t limit,
                                        uint16_t* slots, size_t capacity, size_t* count) {
    if (count == NULL || (rows == NULL && row_count > 0) || row_count > LARGEST_COUNT || limit < 1 ||
        limit > MOST_SLOT_LIMIT || (slots == NULL && capacity > 0)) {
        return METABUFFER_BAD_ARGUMENT;
    }
    for (size_t i = 0; i < row_count; ++i) {
        if (rows[i].sdx < 1 || rows[i].dmultiple < 1 || rows[i].dmultiple > LARGEST_MULTIPLE) {
            return METABUFFER_BAD_ARGUMENT;
        }
    }
    *count = 0;
    if (row_count == 0) return METABUFFER_OK;
    Share* const shares = calloc(row_count, sizeof *shares);
    if (shares == NULL) return METABUFFER_SYSTEM;
    const int64_t total = share_slots(rows, row_count, (int64_t)limit, shares);
    *count = (size_t)total;
    if (*count <= capacity) deal_slots(shares, row_count, total, slots);
    free(shares);
    return *count <= capacity ? METABUFFER_OK : METABUFFER_NO_ROOM;
}

static unsigned slot_bits(size_t row_count) {
    unsigned bits = 1;
    while (((size_t)1 << bits) < row_count) ++bits;
    return bits;
}

size_t metabuffer_slots_in_payload(size_t payload_bytes, size_t row_count) {
    if (payload_bytes <= SLOT_HEADER_BYTES) return 0;
    const size_t slots = (payload_bytes - SLOT_HEADER_BYTES) * 8 / slot_bits(row_count);
    return slots < METABUFFER_SLOTS ? slots : METABUFFER_SLOTS;
}

metabuffer_status metabuffer_write_slots(const uint16_t* slots, size_t count, size_t row_count,
                                         uint8_t* payload, size_t capacity, size_t* bytes) {
    if ((slots == NULL && count > 0) || payload == NULL || bytes == NULL || count > METABUFFER_SLOTS ||
        row_count < 1 || row_count > (size_t)LARGEST_COUNT + 1) {
        return METABUFFER_BAD_ARGUMENT;
    }
    for (size_t i = 0; i < count; ++i) {
        if (slots[i] >= row_count) return METABUFFER_BAD_ARGUMENT;
    }
    const unsigned bits = slot_bits(row_count);
    *bytes = SLOT_HEADER_BYTES + (count * bits + 7) / 8;
    if (*bytes > capacity) return METABUFFER_NO_ROOM;
    memset(payload, 0, *bytes);
    payload[0] = SLOT_MARK;
    payload[1] = (uint8_t)bits;
    payload[2] = (uint8_t)(count & 0xFF);
    payload[3] = (uint8_t)(count >> 8);
    for (size_t at = 0; at < count * bits; ++at) {
        const unsigned bit = (slots[at / bits] >> (at % bits)) & 1U;
        payload[SLOT_HEADER_BYTES + at / 8] |= (uint8_t)(bit << (at % 8));
    }
    return METABUFFER_OK;
}

metabuffer_status metabuffer_read_slots(const uint8_t* payload, size_t bytes, uint16_t* slots,
                                        size_t capacity, size_t* count) {
    if ((payload == NULL && bytes > 0) || (slots == NULL && capacity > 0) || count == NULL) {
        return METABUFFER_BAD_ARGUMENT;
    }
    if (bytes < SLOT_HEADER_BYTES || payload[0] != SLOT_MARK) return METABUFFER_BAD_SLOTS;
    const unsigned bits = payload[1];
    *count = payload[2] | (size_t)payload[3] << 8;
    if (bits < 1 || bits > MOST_SLOT_BITS || bytes != SLOT_HEADER_BYTES + (*count * bits + 7) / 8) {
        return METABUFFER_BAD_SLOTS;
    }
    if (*count > capacity) return METABUFFER_NO_ROOM;
    for (size_t i = 0; i < *count; ++i) slots[i] = 0;
    for (size_t at = 0; at < *count * bits; ++at) {
        const unsigned bit = (payload[SLOT_HEADER_BYTES + at / 8] >> (at % 8)) & 1U;
        slots[at / bits] = (uint16_t)(slots[at / bits] | bit << (at % bits));
    }
    return METABUFFER_OK;
}

/* ---- control scanline ---- */

/* A byte of a scanline: its pixels' bytes in the order R, G, B. */
static uint8_t byte_at(const uint32_t* scanline, size_t at) {
    return (uint8_t)(scanline[at / PIXEL_BYTES] >> (8 * (PIXEL_BYTES - 1 - at % PIXEL_BYTES)));
}
static void put_byte(uint32_t* scanline, size_t at, unsigned value) {
    const unsigned shift = 8 * (unsigned)(PIXEL_BYTES - 1 - at % PIXEL_BYTES);
    uint32_t* const pixel = &scanline[at / PIXEL_BYTES];
    *pixel = (*pixel & ~((uint32_t)0xFF << shift)) | (uint32_t)(value & 0xFF) << shift;
}
static uint16_t word_at(const uint32_t* scanline, size_t at) {
    return (uint16_t)(byte_at(scanline, at) | byte_at(scanline, at + 1) << 8);
}
static void put_word(uint32_t* scanline, size_t at, unsigned value) {
    put_byte(scanline, at, value);
    put_byte(scanline, at + 1, value >> 8);
}
static uint32_t double_at(const uint32_t* scanline, size_t at) {
    return word_at(scanline, at) | (uint32_t)word_at(scanline, at + 2) << 16;
}
static void put_double(uint32_t* scanline, size_t at, uint32_t value) {
    put_word(scanline, at, value & 0xFFFF);
    put_word(scanline, at + 2, value >> 16);
}

/* The CRC-32 of IEEE 802.3 over bytes begin to end - 1; crc: 0, or that of what comes before. */
static uint32_t crc_over(const uint32_t* scanline, size_t begin, size_t end, uint32_t crc) {
    crc = ~crc;
    for (size_t at = begin; at < end; ++at) {
        crc ^= byte_at(scanline, at);
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320U : 0U);
    }
    return ~crc;
}

/* It leaves its own bytes out. */
static uint32_t control_crc(const uint32_t* scanline, size_t end) {
    return crc_over(scanline, HEADER_BYTES, end, crc_over(scanline, 0, CRC_OFFSET, 0));
}

size_t metabuffer_control_bytes(size_t row_count, size_t payload_bytes) {
    return HEADER_BYTES + row_count * ROW_BYTES + LENGTH_BYTES + payload_bytes;
}

metabuffer_status metabuffer_write_control(const metabuffer_control* control, uint32_t* scanline,
                                           size_t width_pixels) {
    if (control == NULL || scanline == NULL || control->kind > METABUFFER_DEPTH ||
        (control->rows == NULL && control->row_count > 0) ||
        (control->payload == NULL && control->payload_bytes > 0)) {
        return METABUFFER_BAD_ARGUMENT;
    }
    if (control->row_count > LARGEST_COUNT || control->payload_bytes > LARGEST_COUNT)
        return METABUFFER_NO_ROOM;
    const size_t end = metabuffer_control_bytes(control->row_count, control->payload_bytes);
    if (width_pixels < (end + PIXEL_BYTES - 1) / PIXEL_BYTES) return METABUFFER_NO_ROOM;
    memset(scanline, 0, width_pixels * sizeof *scanline);
    for (size_t i = 0; i < sizeof kMagic; ++i) put_byte(scanline, i, (unsigned char)kMagic[i]);
    put_byte(scanline, VERSION_OFFSET, CONTROL_VERSION);
    put_byte(scanline, KIND_OFFSET, control->kind);
    put_word(scanline, ROW_COUNT_OFFSET, (unsigned)control->row_count);
    put_double(scanline, NUMBER_OFFSET, control->frame_number);
    size_t at = HEADER_BYTES;
    for (size_t i = 0; i < control->row_count; ++i, at += ROW_BYTES) {
        const metabuffer_row* const row = &control->rows[i];
        put_word(scanline, at, row->dcomp);
        put_word(scanline, at + 2, row->sx);
        put_word(scanline, at + 4, row->sy);
        put_word(scanline, at + 6, row->sdx);
        put_word(scanline, at + 8, row->sdy);
        put_word(scanline, at + 10, (uint16_t)row->dx);
        put_word(scanline, at + 12, (uint16_t)row->dy);
        put_word(scanline, at + 14, row->dmultiple);
    }
    put_word(scanline, at, (unsigned)control->payload_bytes);
    at += LENGTH_BYTES;
    for (size_t i = 0; i < control->payload_bytes; ++i) put_byte(scanline, at + i, control->payload[i]);
    put_double(scanline, CRC_OFFSET, control_crc(scanline, end));
    return METABUFFER_OK;
}

metabuffer_status metabuffer_read_control(const uint32_t* scanline, size_t width_pixels,
                                          metabuffer_control* control, metabuffer_row* rows,
                                          size_t row_capacity, uint8_t* payload, size_t payload_capacity) {
    if (scanline == NULL || (rows == NULL && row_capacity > 0) || (payload == NULL && payload_capacity > 0)) {
        return METABUFFER_BAD_ARGUMENT;
    }
    const size_t bytes = width_pixels * PIXEL_BYTES;
    if (bytes < sizeof kMagic) return METABUFFER_BAD_MAGIC;
    for (size_t i = 0; i < sizeof kMagic; ++i) {
        if (byte_at(scanline, i) != (uint8_t)kMagic[i]) return METABUFFER_BAD_MAGIC;
    }
    if (bytes <= VERSION_OFFSET || byte_at(scanline, VERSION_OFFSET) != CONTROL_VERSION)
        return METABUFFER_BAD_VERSION;
    if (bytes < HEADER_BYTES) return METABUFFER_BAD_CRC;
    const size_t row_count = word_at(scanline, ROW_COUNT_OFFSET);
    const size_t length_at = HEADER_BYTES + row_count * ROW_BYTES;
    if (length_at + LENGTH_BYTES > bytes) return METABUFFER_BAD_CRC;
    const size_t payload_bytes = word_at(scanline, length_at);
    const size_t end = metabuffer_control_bytes(row_count, payload_bytes);
    if (end > bytes || control_crc(scanline, end) != double_at(scanline, CRC_OFFSET))
        return METABUFFER_BAD_CRC;
    if (byte_at(scanline, KIND_OFFSET) > METABUFFER_DEPTH) return METABUFFER_BAD_KIND;
    if (control == NULL) return METABUFFER_OK;

    if (row_count > row_capacity || payload_bytes > payload_capacity) return METABUFFER_NO_ROOM;
    for (size_t i = 0; i < row_count; ++i) {
        const size_t at = HEADER_BYTES + i * ROW_BYTES;
        rows[i].dcomp = word_at(scanline, at);
        rows[i].sx = word_at(scanline, at + 2);
        rows[i].sy = word_at(scanline, at + 4);
        rows[i].sdx = word_at(scanline, at + 6);
        rows[i].sdy = word_at(scanline, at + 8);
        rows[i].dx = (int16_t)word_at(scanline, at + 10);
        rows[i].dy = (int16_t)word_at(scanline, at + 12);
        rows[i].dmultiple = word_at(scanline, at + 14);
    }
    for (size_t i = 0; i < payload_bytes; ++i) payload[i] = byte_at(scanline, length_at + LENGTH_BYTES + i);
    control->kind = byte_at(scanline, KIND_OFFSET);
    control->frame_number = double_at(scanline, NUMBER_OFFSET);
    control->rows = rows;
    control->row_count = row_count;
    control->payload = payload;
    control->payload_bytes = payload_bytes;
    return METABUFFER_OK;
}

/* ---- pixels ---- */

/* value / full * far to the nearest whole number. */
static uint32_t rescaled(uint32_t value, uint32_t full, uint32_t far) {
    return (uint32_t)(((uint64_t)value * far + full / 2) / full);
}

static uint32_t z_of_float(float depth, uint32_t far) {
    if (!(depth < 1.0F)) return far; /* also what is no number */
    return depth > 0.0F ? (uint32_t)((double)depth * far + 0.5) : 0;
}

metabuffer_status metabuffer_pack_depth(metabuffer_depth_format format, metabuffer_depth_type type,
                                        const void* depths, size_t count, int reversed, const uint8_t* alpha,
                                        size_t alpha_stride, uint32_t* link_pixels) {
    if (((depths == NULL || link_pixels == NULL) && count > 0) ||
        (format != METABUFFER_A8Z16 && format != METABUFFER_Z24)) {
        return METABUFFER_BAD_ARGUMENT;
    }
    const uint32_t far = format == METABUFFER_Z24 ? 0xFFFFFFU : 0xFFFFU;
    for (size_t i = 0; i < count; ++i) {
        uint32_t z = far;
        int is_number = 1;
        switch (type) {
            case METABUFFER_DEPTH_FLOAT: {
                const float depth = ((const float*)depths)[i];
                is_number = depth == depth;
                z = z_of_float(depth, far);
                break;
            }
            case METABUFFER_DEPTH_UINT16:
                z = rescaled(((const uint16_t*)depths)[i], 0xFFFFU, far);
                break;
            case METABUFFER_DEPTH_UINT24:
                z = rescaled(((const uint32_t*)depths)[i] & 0xFFFFFFU, 0xFFFFFFU, far);
                break;
            case METABUFFER_DEPTH_UINT32:
                z = rescaled(((const uint32_t*)depths)[i], 0xFFFFFFFFU, far);
                break;
            default:
                return METABUFFER_BAD_ARGUMENT;
        }
        if (reversed != 0 && is_number) z = far - z;
        if (format == METABUFFER_A8Z16) z |= (uint32_t)(alpha == NULL ? 0xFF : alpha[i * alpha_stride]) << 16;
        link_pixels[i] = z;
    }
    return METABUFFER_OK;
}

metabuffer_status metabuffer_pack_colour(const uint8_t* rgb, size_t stride, size_t count,
                                         uint32_t* link_pixels) {
    if (((rgb == NULL || link_pixels == NULL) && count > 0) || stride < PIXEL_BYTES)
        return METABUFFER_BAD_ARGUMENT;
    for (size_t i = 0; i < count; ++i, rgb += stride) {
        link_pixels[i] = (uint32_t)rgb[0] << 16 | (uint32_t)rgb[1] << 8 | rgb[2];
    }
    return METABUFFER_OK;
}
