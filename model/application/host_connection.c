/* For sockets, shared memory and the clock beside C99. */
#define _GNU_SOURCE

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "application/live_protocol.h"

enum { SLOT_LIMIT = 256 };

struct metabuffer_link {
    int socket;
    metabuffer_link_info info;
    char message[LIVE_MESSAGE_BYTES];
    uint32_t* ring;
    size_t ring_bytes;
    live_grant granted[LIVE_RING_PAIRS]; /* pairs that are free, the oldest first */
    size_t granted_count;
    live_grant begun[LIVE_RING_PAIRS]; /* pairs that the application fills, the oldest first */
    size_t begun_count;
    unsigned char input[sizeof(live_grant)]; /* of a grant that has come in part */
    size_t input_bytes;
    size_t displays;
    uint16_t* slots; /* SLOT_LIMIT + displays */
    metabuffer_row* fitting;
    size_t* index_of_fitting;
    uint8_t* payload;
};

metabuffer_status metabuffer_default_socket(const char* wall_name, char* path, size_t capacity) {
    if (wall_name == NULL || path == NULL) return METABUFFER_BAD_ARGUMENT;
    const char* const folder = getenv("XDG_RUNTIME_DIR");
    const int length =
        folder != NULL && folder[0] == '/'
            ? snprintf(path, capacity, "%s/metabuffer-%s.sock", folder, wall_name)
            : snprintf(path, capacity, "/tmp/metabuffer-%lu-%s.sock", (unsigned long)getuid(), wall_name);
    return length >= 0 && (size_t)length < capacity ? METABUFFER_OK : METABUFFER_NO_ROOM;
}

/* ---- waiting ---- */

static int64_t now_ms(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000 + time.tv_nsec / 1000000;
}

/* The end of a time that begins now; below 0: none. */
static int64_t end_of(int timeout_ms) { return timeout_ms < 0 ? -1 : now_ms() + timeout_ms; }

/* Waits until the socket has something to read, or has ended. */
static metabuffer_status wait_for_input(int socket, int64_t end_ms) {
    for (;;) {
        int left_ms = -1;
        if (end_ms >= 0) {
            const int64_t left = end_ms - now_ms();
            left_ms = left < 0 ? 0 : (int)left;
        }
        struct pollfd wanted = {socket, POLLIN, 0};
        const int ready = poll(&wanted, 1, left_ms);
        if (ready > 0) return METABUFFER_OK;
        if (ready == 0) return METABUFFER_TIMEOUT;
        if (errno != EINTR) return METABUFFER_SYSTEM;
    }
}

static metabuffer_status send_all(int socket, const void* data, size_t bytes) {
    const char* next = data;
    while (bytes > 0) {
        const ssize_t sent = send(socket, next, bytes, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent < 0) return errno == EPIPE || errno == ECONNRESET ? METABUFFER_ENDED : METABUFFER_SYSTEM;
        next += sent;
        bytes -= (size_t)sent;
    }
    return METABUFFER_OK;
}

/* ---- opening ---- */

/* Receives the welcome and the descriptor that comes with it; *descriptor is -1 if none does. */
static metabuffer_status receive_welcome(int socket, int64_t end_ms, live_welcome* welcome, int* descriptor) {
    size_t bytes = 0;
    *descriptor = -1;
    while (bytes < sizeof *welcome) {
        const metabuffer_status status = wait_for_input(socket, end_ms);
        if (status != METABUFFER_OK) return status;
        union {
            struct cmsghdr header;
            char bytes[CMSG_SPACE(sizeof(int))];
        } control;
        struct iovec part = {(char*)welcome + bytes, sizeof *welcome - bytes};
        struct msghdr message;
        memset(&message, 0, sizeof message);
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = control.bytes;
        message.msg_controllen = sizeof control.bytes;
        const ssize_t received = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
        if (received < 0 && errno == EINTR) continue;
        if (received < 0) return errno == ECONNRESET ? METABUFFER_ENDED : METABUFFER_SYSTEM;
        if (received == 0) return METABUFFER_ENDED;
        bytes += (size_t)received;
        const struct cmsghdr* const carried = CMSG_FIRSTHDR(&message);
        if (carried != NULL && carried->cmsg_level == SOL_SOCKET && carried->cmsg_type == SCM_RIGHTS &&
            *descriptor < 0) {
            memcpy(descriptor, CMSG_DATA(carried), sizeof *descriptor);
        }
    }
    return METABUFFER_OK;
}

static metabuffer_status connect_to(const char* path, int* descriptor) {
    struct sockaddr_un address;
    memset(&address, 0, sizeof address);
    address.sun_family = AF_UNIX;
    const size_t length = strlen(path);
    if (length >= sizeof address.sun_path) return METABUFFER_NO_ROOM;
    memcpy(address.sun_path, path, length);
    *descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (*descriptor < 0) return METABUFFER_SYSTEM;
    if (connect(*descriptor, (const struct sockaddr*)&address, sizeof address) == 0) return METABUFFER_OK;
    return errno == ENOENT || errno == ECONNREFUSED ? METABUFFER_NO_WALL : METABUFFER_SYSTEM;
}

/* Maps the ring, if it is as large as its pairs need. */
static metabuffer_status map_ring(metabuffer_link* link, int descriptor) {
    struct stat file;
    const int32_t width = link->info.image_width_pixels, height = link->info.image_height_pixels;
    if (descriptor < 0 || width < 1 || height < 1) return METABUFFER_ENDED;
    link->ring_bytes = live_ring_bytes(width, height);
    if (fstat(descriptor, &file) != 0) return METABUFFER_SYSTEM;
    if ((uint64_t)file.st_size < link->ring_bytes) return METABUFFER_ENDED;
    void* const ring = mmap(NULL, link->ring_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (ring == MAP_FAILED) return METABUFFER_SYSTEM;
    link->ring = ring;
    return METABUFFER_OK;
}

static metabuffer_status make_room_for_slots(metabuffer_link* link) {
    link->displays = (size_t)link->info.wall.columns * (size_t)link->info.wall.rows;
    if (link->info.slots_wanted == METABUFFER_NO_SLOTS) return METABUFFER_OK;
    link->slots = calloc(SLOT_LIMIT + link->displays, sizeof *link->slots);
    link->fitting = calloc(link->displays, sizeof *link->fitting);
    link->index_of_fitting = calloc(link->displays, sizeof *link->index_of_fitting);
    link->payload = malloc(METABUFFER_PAYLOAD_BYTES);
    const int complete = link->slots != NULL && link->fitting != NULL && link->index_of_fitting != NULL &&
                         link->payload != NULL;
    return complete ? METABUFFER_OK : METABUFFER_SYSTEM;
}

static metabuffer_status open_link(metabuffer_link* link, const char* path, const live_hello* hello,
                                   int64_t end_ms) {
    metabuffer_status status = connect_to(path, &link->socket);
    if (status == METABUFFER_OK) status = send_all(link->socket, hello, sizeof *hello);
    if (status != METABUFFER_OK && status != METABUFFER_ENDED) return status;
    /* A wall that has closed the stream may have said why before. */
    live_welcome welcome;
    int ring = -1;
    status = receive_welcome(link->socket, end_ms, &welcome, &ring);
    if (status == METABUFFER_OK && welcome.magic != LIVE_MAGIC) status = METABUFFER_NO_WALL;
    if (status == METABUFFER_OK) {
        memcpy(link->message, welcome.message, sizeof link->message - 1);
        if (welcome.accepted == 0 || welcome.version != LIVE_VERSION) status = METABUFFER_REFUSED;
    }
    if (status == METABUFFER_OK) {
        link->info = welcome.info;
        status = map_ring(link, ring);
    }
    if (status == METABUFFER_OK) status = make_room_for_slots(link);
    if (ring >= 0) close(ring);
    return status;
}

metabuffer_status metabuffer_open_link(const char* socket_path, const char* link_name,
                                       int32_t image_width_pixels, int32_t image_height_pixels,
                                       metabuffer_depth_format depth_format, int timeout_ms,
                                       metabuffer_link** link) {
    if (link == NULL) return METABUFFER_BAD_ARGUMENT;
    *link = NULL;
    if (socket_path == NULL || link_name == NULL || image_width_pixels < 0 || image_height_pixels < 0) {
        return METABUFFER_BAD_ARGUMENT;
    }
    live_hello hello;
    memset(&hello, 0, sizeof hello);
    hello.magic = LIVE_MAGIC;
    hello.version = LIVE_VERSION;
    if (strlen(link_name) >= sizeof hello.link_name) return METABUFFER_NO_ROOM;
    strcpy(hello.link_name, link_name);
    hello.image_width_pixels = image_width_pixels;
    hello.image_height_pixels = image_height_pixels;
    hello.depth_format = depth_format;

    metabuffer_link* const opened = calloc(1, sizeof *opened);
    if (opened == NULL) return METABUFFER_SYSTEM;
    opened->socket = -1;
    const metabuffer_status status = open_link(opened, socket_path, &hello, end_of(timeout_ms));
    if (status == METABUFFER_OK || status == METABUFFER_REFUSED) {
        *link = opened;
    } else {
        const int error = errno;
        metabuffer_close_link(opened);
        errno = error;
    }
    return status;
}

void metabuffer_close_link(metabuffer_link* link) {
    if (link == NULL) return;
    if (link->ring != NULL) munmap(link->ring, link->ring_bytes);
    if (link->socket >= 0) close(link->socket);
    free(link->slots);
    free(link->fitting);
    free(link->index_of_fitting);
    free(link->payload);
    free(link);
}

const char* metabuffer_link_message(const metabuffer_link* link) { return link == NULL ? "" : link->message; }

const metabuffer_link_info* metabuffer_link_get_info(const metabuffer_link* link) {
    return link == NULL ? NULL : &link->info;
}

/* ---- pairs ---- */

static metabuffer_status receive_grant(metabuffer_link* link, int64_t end_ms) {
    while (link->input_bytes < sizeof link->input) {
        const metabuffer_status status = wait_for_input(link->socket, end_ms);
        if (status != METABUFFER_OK) return status;
        const ssize_t received =
            recv(link->socket, link->input + link->input_bytes, sizeof link->input - link->input_bytes, 0);
        if (received < 0 && errno == EINTR) continue;
        if (received < 0) return errno == ECONNRESET ? METABUFFER_ENDED : METABUFFER_SYSTEM;
        if (received == 0) return METABUFFER_ENDED;
        link->input_bytes += (size_t)received;
    }
    link->input_bytes = 0;
    live_grant grant;
    memcpy(&grant, link->input, sizeof grant);
    if (grant.index >= LIVE_RING_PAIRS || link->granted_count == LIVE_RING_PAIRS) return METABUFFER_ENDED;
    link->granted[link->granted_count++] = grant;
    return METABUFFER_OK;
}

metabuffer_status metabuffer_begin_pair(metabuffer_link* link, int timeout_ms, metabuffer_pair* pair) {
    if (link == NULL || pair == NULL || link->ring == NULL || link->begun_count == LIVE_RING_PAIRS) {
        return METABUFFER_BAD_ARGUMENT;
    }
    if (link->granted_count == 0) {
        const metabuffer_status status = receive_grant(link, end_of(timeout_ms));
        if (status != METABUFFER_OK) return status;
    }
    const live_grant grant = link->granted[0];
    memmove(link->granted, link->granted + 1, --link->granted_count * sizeof grant);
    link->begun[link->begun_count++] = grant;
    const size_t words = live_frame_words(link->info.image_width_pixels, link->info.image_height_pixels);
    pair->colour = link->ring + grant.index * 2 * words;
    pair->depth = pair->colour + words;
    pair->frame_number = grant.frame_number;
    pair->index = grant.index;
    return METABUFFER_OK;
}

metabuffer_status metabuffer_submit_pair(metabuffer_link* link, const metabuffer_pair* pair) {
    if (link == NULL || pair == NULL || link->begun_count == 0 || link->begun[0].index != pair->index) {
        return METABUFFER_BAD_ARGUMENT;
    }
    const live_submission submission = link->begun[0];
    memmove(link->begun, link->begun + 1, --link->begun_count * sizeof submission);
    return send_all(link->socket, &submission, sizeof submission);
}

/* The rows that the composers' buffers can hold, for which alone the machine takes slots. */
static size_t find_fitting_rows(const metabuffer_link* link, const metabuffer_row* rows, size_t row_count) {
    size_t fitting = 0;
    for (size_t i = 0; i < row_count && fitting < link->displays; ++i) {
        const int64_t lines = rows[i].dmultiple <= 1 ? 0 : link->info.wall.smooths != 0 ? 2 : 1;
        if (link->info.buffer_pixels < lines * rows[i].sdx + link->info.ready_space_pixels) continue;
        link->fitting[fitting] = rows[i];
        link->index_of_fitting[fitting++] = i;
    }
    return fitting;
}

/* The payload of the depth frame: the longest slot table that has room. */
static metabuffer_status write_slot_payload(const metabuffer_link* link, const metabuffer_row* rows,
                                            size_t row_count, size_t* bytes) {
    *bytes = 0;
    const size_t fitting = find_fitting_rows(link, rows, row_count);
    if (fitting == 0) return METABUFFER_OK;
    const size_t scanline_bytes = (size_t)link->info.image_width_pixels * 3;
    const size_t least_bytes = metabuffer_control_bytes(0, 0);
    size_t room = scanline_bytes > least_bytes ? scanline_bytes - least_bytes : 0;
    if (room > METABUFFER_PAYLOAD_BYTES) room = METABUFFER_PAYLOAD_BYTES;
    const size_t most = metabuffer_slots_in_payload(room, row_count);
    size_t count = 0;
    if (link->info.slots_wanted == METABUFFER_EQUAL_SLOTS) {
        for (count = 0; count < fitting; ++count) link->slots[count] = (uint16_t)count;
    } else {
        size_t limit = SLOT_LIMIT;
        do {
            const metabuffer_status status = metabuffer_make_slots(link->fitting, fitting, limit, link->slots,
                                                                   SLOT_LIMIT + link->displays, &count);
            if (status != METABUFFER_OK) return status;
        } while (count > most && --limit > 0);
    }
    if (count > most) return METABUFFER_OK;
    for (size_t i = 0; i < count; ++i) link->slots[i] = (uint16_t)link->index_of_fitting[link->slots[i]];
    return metabuffer_write_slots(link->slots, count, row_count, link->payload, METABUFFER_PAYLOAD_BYTES,
                                  bytes);
}

metabuffer_status metabuffer_write_controls(const metabuffer_link* link, const metabuffer_pair* pair,
                                            const metabuffer_row* rows, size_t row_count) {
    if (link == NULL || pair == NULL || (rows == NULL && row_count > 0)) return METABUFFER_BAD_ARGUMENT;
    metabuffer_control control;
    memset(&control, 0, sizeof control);
    control.frame_number = pair->frame_number;
    control.kind = METABUFFER_COLOUR;
    control.rows = rows;
    control.row_count = row_count;
    const size_t width = (size_t)link->info.image_width_pixels;
    metabuffer_status status = metabuffer_write_control(&control, pair->colour, width);
    if (status != METABUFFER_OK) return status;
    memset(&control, 0, sizeof control);
    control.frame_number = pair->frame_number;
    control.kind = METABUFFER_DEPTH;
    if (link->info.slots_wanted != METABUFFER_NO_SLOTS) {
        status = write_slot_payload(link, rows, row_count, &control.payload_bytes);
        if (status != METABUFFER_OK) return status;
        control.payload = link->payload;
    }
    return metabuffer_write_control(&control, pair->depth, width);
}
