/*
 * Sends what an unmodified OpenGL program draws to a wall: preloaded, it stands in front of the functions by which a
 * program swaps its buffers (GLX and EGL), takes colour and depth of the back buffer, and submits them as a pair. It is
 * found by symbol, by glXGetProcAddress and eglGetProcAddress, and by dlsym. metabuffer-gl starts programs with it.
 *
 * | variable | content |
 * | --- | --- |
 * | METABUFFER_GL_SOCKET | path of the wall's socket |
 * | METABUFFER_GL_LINK | the renderer's name in the wall's scenario |
 * | METABUFFER_GL_VIEWPORT | X,Y,MULTIPLE: where the image lies in the display space |
 *
 * What goes wrong is one line on standard error, and the program goes on without the wall.
 */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "application/metabuffer_host.h"

/* ---- what is used of OpenGL, GLX and EGL, whose headers a build need not have ---- */

typedef unsigned int GLenum, GLuint;
typedef int GLint, GLsizei;

enum {
    GL_BACK = 0x0405,
    GL_UNSIGNED_BYTE = 0x1401,
    GL_UNSIGNED_INT = 0x1405,
    GL_DEPTH_COMPONENT = 0x1902,
    GL_RGBA = 0x1908,
    GL_DEPTH_BITS = 0x0D56,
    GL_PACK_SWAP_BYTES = 0x0D00,
    GL_PACK_LSB_FIRST = 0x0D01,
    GL_PACK_ROW_LENGTH = 0x0D02,
    GL_PACK_SKIP_ROWS = 0x0D03,
    GL_PACK_SKIP_PIXELS = 0x0D04,
    GL_PACK_ALIGNMENT = 0x0D05,
    GL_READ_BUFFER = 0x0C02,
    GL_DEPTH = 0x1801,
    GL_PIXEL_PACK_BUFFER = 0x88EB,
    GL_PIXEL_PACK_BUFFER_BINDING = 0x88ED,
    GL_READ_FRAMEBUFFER = 0x8CA8,
    GL_READ_FRAMEBUFFER_BINDING = 0x8CAA,
    GL_FRAMEBUFFER = 0x8D40,
    GL_FRAMEBUFFER_BINDING = 0x8CA6,
    GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE = 0x8216,
    GL_EXTENSIONS = 0x1F03,
    GL_VERSION = 0x1F02,
    GLX_WIDTH = 0x801D,
    GLX_HEIGHT = 0x801E,
    EGL_HEIGHT = 0x3056,
    EGL_WIDTH = 0x3057
};

typedef void (*Function)(void);
typedef Function (*GetProcAddress)(const char* name);
typedef void* (*Dlsym)(void* handle, const char* name);

typedef struct OpenGl {
    int is_es;
    int version; /* major */
    void (*get_integer)(GLenum name, GLint* values);
    GLenum (*get_error)(void);
    const unsigned char* (*get_string)(GLenum name);
    void (*pixel_store)(GLenum name, GLint value);
    void (*read_pixels)(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,
                        void* pixels);
    void (*read_buffer)(GLenum buffer);                          /* null in ES 2 */
    void (*bind_buffer)(GLenum target, GLuint buffer);           /* null before OpenGL 1.5 */
    void (*bind_framebuffer)(GLenum target, GLuint framebuffer); /* null before OpenGL 3 */
    void (*get_attachment)(GLenum target, GLenum attachment, GLenum name, GLint* value);
} OpenGl;

/* ---- what the library keeps, under one lock ---- */

typedef struct Taker {
    pthread_mutex_t lock;
    int has_tried;
    int is_off; /* it has said why */
    metabuffer_link* link;
    metabuffer_viewport viewport;
    metabuffer_row* rows;
    size_t row_count;
    const void* drawable; /* of which pictures are taken: the first one that is swapped */
    OpenGl gl;
    unsigned char* colours;
    uint32_t* depths;
    int said_size;
} Taker;

static Taker taker = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void say(const char* format, ...) {
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    fprintf(stderr, "metabuffer-gl: %s\n", line);
}

/* Says why, and takes no pictures any more. */
static void give_up(const char* why) {
    say("%s; the program goes on without the wall", why);
    taker.is_off = 1;
    metabuffer_close_link(taker.link);
    taker.link = NULL;
}

/* ---- the functions behind the ones that the program calls ---- */

static Dlsym real_dlsym(void) {
    static Dlsym found;
    static const char* const versions[] = {"GLIBC_2.34", "GLIBC_2.2.5", "GLIBC_2.17", "GLIBC_2.0"};
    for (size_t i = 0; found == NULL && i < sizeof versions / sizeof *versions; ++i) {
        void* const symbol = dlvsym(RTLD_NEXT, "dlsym", versions[i]);
        memcpy(&found, &symbol, sizeof found);
    }
    return found;
}

/* The function of that name in the library; null if there is none. */
static Function real_function(const char* library, const char* name) {
    const Dlsym find = real_dlsym();
    if (find == NULL) return NULL;
    void* symbol = find(RTLD_NEXT, name);
    if (symbol == NULL) {
        void* const handle = dlopen(library, RTLD_LAZY | RTLD_LOCAL);
        if (handle != NULL) symbol = find(handle, name);
    }
    Function function = NULL;
    memcpy(&function, &symbol, sizeof function);
    return function;
}

static const char kGlx[] = "libGL.so.1";
static const char kEgl[] = "libEGL.so.1";

static Function glx_function(const char* name) {
    const GetProcAddress get = (GetProcAddress)real_function(kGlx, "glXGetProcAddressARB");
    return get == NULL ? NULL : get(name);
}
static Function egl_function(const char* name) {
    const GetProcAddress get = (GetProcAddress)real_function(kEgl, "eglGetProcAddress");
    return get == NULL ? NULL : get(name);
}

static int find_opengl(GetProcAddress get) {
    OpenGl* const gl = &taker.gl;
    gl->get_integer = (void (*)(GLenum, GLint*))get("glGetIntegerv");
    gl->get_error = (GLenum(*)(void))get("glGetError");
    gl->get_string = (const unsigned char* (*)(GLenum))get("glGetString");
    gl->pixel_store = (void (*)(GLenum, GLint))get("glPixelStorei");
    gl->read_pixels = (void (*)(GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void*))get("glReadPixels");
    if (gl->get_integer == NULL || gl->get_error == NULL || gl->get_string == NULL ||
        gl->pixel_store == NULL || gl->read_pixels == NULL) {
        return 0;
    }
    const char* version = (const char*)gl->get_string(GL_VERSION);
    if (version == NULL) return 0;
    gl->is_es = strncmp(version, "OpenGL ES", strlen("OpenGL ES")) == 0;
    version += strcspn(version, "0123456789");
    gl->version = atoi(version);
    if (!gl->is_es || gl->version >= 3) gl->read_buffer = (void (*)(GLenum))get("glReadBuffer");
    if (!gl->is_es || gl->version >= 3) gl->bind_buffer = (void (*)(GLenum, GLuint))get("glBindBuffer");
    if (gl->is_es || gl->version >= 3) {
        gl->bind_framebuffer = (void (*)(GLenum, GLuint))get("glBindFramebuffer");
    }
    if (gl->version >= 3) {
        gl->get_attachment =
            (void (*)(GLenum, GLenum, GLenum, GLint*))get("glGetFramebufferAttachmentParameteriv");
    }
    return 1;
}

/* ---- taking a picture ---- */

/* State of the context that reading depends on, each with the value that it needs; 0 where there is no such state. */
typedef struct PackState {
    GLenum name;
    GLint needed;
    int from_es; /* the version of OpenGL ES that has it; 0: none */
} PackState;

static const PackState kPackStates[] = {
    {GL_PACK_ALIGNMENT, 1, 2},   {GL_PACK_ROW_LENGTH, 0, 3}, {GL_PACK_SKIP_ROWS, 0, 3},
    {GL_PACK_SKIP_PIXELS, 0, 3}, {GL_PACK_SWAP_BYTES, 0, 0}, {GL_PACK_LSB_FIRST, 0, 0},
};
enum { PACK_STATES = sizeof kPackStates / sizeof *kPackStates };

typedef struct SavedState {
    GLint pack[PACK_STATES];
    GLint pack_buffer;
    GLint framebuffer;
    GLint read_buffer;
} SavedState;

static int has_pack_state(const PackState* state) {
    return !taker.gl.is_es || (state->from_es != 0 && taker.gl.version >= state->from_es);
}

static GLenum framebuffer_target(void) {
    return taker.gl.version >= 3 ? GL_READ_FRAMEBUFFER : GL_FRAMEBUFFER;
}

/* Makes the back buffer what is read, tightly packed, into memory. */
static void set_state(SavedState* saved) {
    const OpenGl* const gl = &taker.gl;
    memset(saved, 0, sizeof *saved);
    if (gl->bind_framebuffer != NULL) {
        gl->get_integer(gl->version >= 3 ? GL_READ_FRAMEBUFFER_BINDING : GL_FRAMEBUFFER_BINDING,
                        &saved->framebuffer);
        if (saved->framebuffer != 0) gl->bind_framebuffer(framebuffer_target(), 0);
    }
    if (gl->read_buffer != NULL) {
        gl->get_integer(GL_READ_BUFFER, &saved->read_buffer);
        gl->read_buffer(GL_BACK);
    }
    if (gl->bind_buffer != NULL) {
        gl->get_integer(GL_PIXEL_PACK_BUFFER_BINDING, &saved->pack_buffer);
        if (saved->pack_buffer != 0) gl->bind_buffer(GL_PIXEL_PACK_BUFFER, 0);
    }
    for (size_t i = 0; i < PACK_STATES; ++i) {
        if (!has_pack_state(&kPackStates[i])) continue;
        gl->get_integer(kPackStates[i].name, &saved->pack[i]);
        gl->pixel_store(kPackStates[i].name, kPackStates[i].needed);
    }
}

static void restore_state(const SavedState* saved) {
    const OpenGl* const gl = &taker.gl;
    for (size_t i = 0; i < PACK_STATES; ++i) {
        if (has_pack_state(&kPackStates[i])) gl->pixel_store(kPackStates[i].name, saved->pack[i]);
    }
    if (saved->pack_buffer != 0) gl->bind_buffer(GL_PIXEL_PACK_BUFFER, (GLuint)saved->pack_buffer);
    if (gl->read_buffer != NULL) gl->read_buffer((GLenum)saved->read_buffer);
    if (saved->framebuffer != 0) gl->bind_framebuffer(framebuffer_target(), (GLuint)saved->framebuffer);
}

static int has_depth(void) {
    const OpenGl* const gl = &taker.gl;
    GLint bits = 0;
    if (gl->get_attachment != NULL) {
        gl->get_attachment(GL_READ_FRAMEBUFFER, GL_DEPTH, GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE, &bits);
    } else {
        gl->get_integer(GL_DEPTH_BITS, &bits);
    }
    return bits > 0;
}

/* Whether this OpenGL can read the depth buffer: OpenGL ES can by an extension alone. */
static int can_read_depth(void) {
    if (!taker.gl.is_es) return 1;
    const char* const extensions = (const char*)taker.gl.get_string(GL_EXTENSIONS);
    return extensions != NULL && strstr(extensions, "GL_NV_read_depth") != NULL;
}

/* Reads the back buffer into colours and depths, bottom row first. */
static int read_back_buffer(int32_t width, int32_t height) {
    const OpenGl* const gl = &taker.gl;
    /* So that what comes is of the reading. A context that is lost has errors without end. */
    for (int errors = 0; errors < 16 && gl->get_error() != 0; ++errors) {
    }
    gl->read_pixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, taker.colours);
    gl->read_pixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, taker.depths);
    return gl->get_error() == 0;
}

static void submit_picture(void) {
    metabuffer_pair pair;
    const metabuffer_link_info* const info = metabuffer_link_get_info(taker.link);
    metabuffer_status status = metabuffer_begin_pair(taker.link, -1, &pair);
    const size_t width = (size_t)info->image_width_pixels, height = (size_t)info->image_height_pixels;
    if (status == METABUFFER_OK) {
        status = metabuffer_write_controls(taker.link, &pair, taker.rows, taker.row_count);
    }
    for (size_t line = 0; status == METABUFFER_OK && line < height; ++line) {
        const size_t from = (height - 1 - line) * width, to = (line + 1) * width;
        metabuffer_pack_colour(taker.colours + 4 * from, 4, width, pair.colour + to);
        metabuffer_pack_depth(info->depth_format, METABUFFER_DEPTH_UINT32, taker.depths + from, width, 0,
                              taker.colours + 4 * from + 3, 4, pair.depth + to);
    }
    if (status == METABUFFER_OK) status = metabuffer_submit_pair(taker.link, &pair);
    if (status != METABUFFER_OK) give_up(metabuffer_status_text(status));
}

/* ---- connecting ---- */

static int read_viewport(const char* text) {
    int used = 0;
    const int read = text == NULL ? 0
                                  : sscanf(text, "%d,%d,%d%n", &taker.viewport.x, &taker.viewport.y,
                                           &taker.viewport.multiple, &used);
    return read == 3 && text[used] == '\0';
}

static void connect_to_wall(void) {
    const char* const socket = getenv("METABUFFER_GL_SOCKET");
    const char* const name = getenv("METABUFFER_GL_LINK");
    char line[512];
    if (socket == NULL || name == NULL || !read_viewport(getenv("METABUFFER_GL_VIEWPORT"))) {
        give_up("its variables are not set; start the program by metabuffer-gl");
        return;
    }
    metabuffer_status status =
        metabuffer_open_link(socket, name, 0, 0, METABUFFER_ANY_DEPTH, -1, &taker.link);
    if (status != METABUFFER_OK) {
        const char* const message = metabuffer_link_message(taker.link);
        snprintf(line, sizeof line, "%s: %s", socket,
                 *message != '\0' ? message : metabuffer_status_text(status));
        give_up(line);
        return;
    }
    const metabuffer_link_info* const info = metabuffer_link_get_info(taker.link);
    const size_t displays = (size_t)info->wall.columns * (size_t)info->wall.rows;
    const size_t pixels = (size_t)info->image_width_pixels * (size_t)info->image_height_pixels;
    taker.rows = calloc(displays, sizeof *taker.rows);
    taker.colours = malloc(pixels * 4);
    taker.depths = malloc(pixels * sizeof *taker.depths);
    if (taker.rows == NULL || taker.colours == NULL || taker.depths == NULL) {
        give_up("there is no memory for its pictures");
        return;
    }
    status = metabuffer_split_viewport(&taker.viewport, info->image_width_pixels, info->image_height_pixels,
                                       &info->wall, taker.rows, displays, &taker.row_count);
    if (status != METABUFFER_OK) give_up(metabuffer_status_text(status));
}

/* Takes the picture that is about to be shown. */
static void take_picture(const void* drawable, int width, int height, GetProcAddress get) {
    pthread_mutex_lock(&taker.lock);
    if (!taker.has_tried) {
        taker.has_tried = 1;
        taker.drawable = drawable;
        if (!find_opengl(get)) {
            give_up("this OpenGL lacks a function");
        } else {
            connect_to_wall();
        }
        if (taker.link != NULL && !can_read_depth()) {
            give_up("this OpenGL ES cannot read its depth buffer (GL_NV_read_depth)");
        }
    }
    const metabuffer_link_info* const info = metabuffer_link_get_info(taker.link);
    if (info != NULL && drawable == taker.drawable) {
        if (width != info->image_width_pixels || height != info->image_height_pixels) {
            if (!taker.said_size) {
                say("the window has %dx%d pixels and the link %dx%d; no picture is taken until they are the "
                    "same",
                    width, height, info->image_width_pixels, info->image_height_pixels);
            }
            taker.said_size = 1;
        } else {
            taker.said_size = 0;
            SavedState saved;
            set_state(&saved);
            const int depth = has_depth();
            const int is_read = depth && read_back_buffer(width, height);
            restore_state(&saved);
            if (!depth) {
                give_up("the window has no depth buffer");
            } else if (!is_read) {
                give_up("this OpenGL does not give its depth buffer away");
            } else {
                submit_picture();
            }
        }
    }
    pthread_mutex_unlock(&taker.lock);
}

/* ---- in front of GLX and EGL ---- */

#define PUBLIC __attribute__((visibility("default")))

PUBLIC void glXSwapBuffers(void* display, unsigned long drawable) {
    typedef void (*QueryDrawable)(void*, unsigned long, int, unsigned*);
    const QueryDrawable query = (QueryDrawable)real_function(kGlx, "glXQueryDrawable");
    unsigned width = 0, height = 0;
    if (query != NULL && !taker.is_off) {
        query(display, drawable, GLX_WIDTH, &width);
        query(display, drawable, GLX_HEIGHT, &height);
        take_picture((const void*)drawable, (int)width, (int)height, glx_function);
    }
    void (*const swap)(void*, unsigned long) =
        (void (*)(void*, unsigned long))real_function(kGlx, "glXSwapBuffers");
    if (swap != NULL) swap(display, drawable);
}

static void take_egl_picture(void* display, void* surface) {
    typedef unsigned (*QuerySurface)(void*, void*, int, int*);
    const QuerySurface query = (QuerySurface)real_function(kEgl, "eglQuerySurface");
    int width = 0, height = 0;
    if (query == NULL || taker.is_off) return;
    query(display, surface, EGL_WIDTH, &width);
    query(display, surface, EGL_HEIGHT, &height);
    take_picture(surface, width, height, egl_function);
}

PUBLIC unsigned eglSwapBuffers(void* display, void* surface) {
    take_egl_picture(display, surface);
    unsigned (*const swap)(void*, void*) = (unsigned (*)(void*, void*))real_function(kEgl, "eglSwapBuffers");
    return swap == NULL ? 0 : swap(display, surface);
}

typedef unsigned (*SwapWithDamage)(void*, void*, const int*, int);

static unsigned swap_with_damage(const char* name, void* display, void* surface, const int* rectangles,
                                 int count) {
    take_egl_picture(display, surface);
    const SwapWithDamage swap = (SwapWithDamage)egl_function(name);
    return swap == NULL ? 0 : swap(display, surface, rectangles, count);
}
PUBLIC unsigned eglSwapBuffersWithDamageEXT(void* display, void* surface, const int* rectangles, int count) {
    return swap_with_damage("eglSwapBuffersWithDamageEXT", display, surface, rectangles, count);
}
PUBLIC unsigned eglSwapBuffersWithDamageKHR(void* display, void* surface, const int* rectangles, int count) {
    return swap_with_damage("eglSwapBuffersWithDamageKHR", display, surface, rectangles, count);
}

PUBLIC int vkCreateInstance(const void* info, const void* allocator, void* instance) {
    int (*const create)(const void*, const void*, void*) =
        (int (*)(const void*, const void*, void*))real_function("libvulkan.so.1", "vkCreateInstance");
    say("the program uses Vulkan, of which no pictures are taken");
    return create == NULL ? -3 : create(info, allocator, instance); /* VK_ERROR_INITIALIZATION_FAILED */
}

PUBLIC Function glXGetProcAddress(const char* name);
PUBLIC Function glXGetProcAddressARB(const char* name);
PUBLIC Function eglGetProcAddress(const char* name);

static const struct {
    const char* name;
    Function function;
} kInFront[] = {
    {"glXSwapBuffers", (Function)glXSwapBuffers},
    {"glXGetProcAddress", (Function)glXGetProcAddress},
    {"glXGetProcAddressARB", (Function)glXGetProcAddressARB},
    {"eglSwapBuffers", (Function)eglSwapBuffers},
    {"eglSwapBuffersWithDamageEXT", (Function)eglSwapBuffersWithDamageEXT},
    {"eglSwapBuffersWithDamageKHR", (Function)eglSwapBuffersWithDamageKHR},
    {"eglGetProcAddress", (Function)eglGetProcAddress},
    {"vkCreateInstance", (Function)vkCreateInstance},
};

/* This library's function of that name; null if it has none. */
static Function in_front(const char* name) {
    for (size_t i = 0; name != NULL && i < sizeof kInFront / sizeof *kInFront; ++i) {
        if (strcmp(name, kInFront[i].name) == 0) return kInFront[i].function;
    }
    return NULL;
}

PUBLIC Function glXGetProcAddressARB(const char* name) {
    const Function real = glx_function(name);
    const Function own = in_front(name);
    return real != NULL && own != NULL ? own : real;
}
PUBLIC Function glXGetProcAddress(const char* name) { return glXGetProcAddressARB(name); }
PUBLIC Function eglGetProcAddress(const char* name) {
    const Function real = egl_function(name);
    const Function own = in_front(name);
    return real != NULL && own != NULL ? own : real;
}

PUBLIC void* dlsym(void* handle, const char* name) {
    const Dlsym find = real_dlsym();
    void* const real = find == NULL ? NULL : find(handle, name);
    const Function own = in_front(name);
    if (real == NULL || own == NULL) return real;
    void* symbol = NULL;
    memcpy(&symbol, &own, sizeof symbol);
    return symbol;
}
