"""An OpenGL program that has everything bound that reading a picture depends on: a framebuffer object of another colour, a
pixel-pack buffer, pixel-pack parameters. Swaps its buffers twice and ends with what has changed, which should be nothing.

usage: opengl_state.py WIDTH HEIGHT
"""

import ctypes
import sys

SDL = ctypes.CDLL("libSDL2-2.0.so.0")
SDL.SDL_CreateWindow.restype = SDL.SDL_GL_CreateContext.restype = SDL.SDL_GL_GetProcAddress.restype = ctypes.c_void_p
SDL.SDL_GL_CreateContext.argtypes = SDL.SDL_GL_SwapWindow.argtypes = [ctypes.c_void_p]
VIDEO, OPENGL, DEPTH_SIZE = 0x20, 2, 6  # SDL_INIT_VIDEO, SDL_WINDOW_OPENGL, SDL_GL_DEPTH_SIZE
COLOUR_AND_DEPTH, RGBA8, RENDERBUFFER, FRAMEBUFFER, ATTACHMENT_0 = 0x4100, 0x8058, 0x8D41, 0x8D40, 0x8CE0
PACK_BUFFER, STREAM_READ = 0x88EB, 0x88E1
# What glGetIntegerv is asked for, and what the program sets it to.
PACK = {0x0D00: 1, 0x0D02: 77, 0x0D03: 3, 0x0D04: 5, 0x0D05: 8}  # swap bytes, row length, skip rows, skip pixels, alignment
BINDINGS = (0x8CA6, 0x8CAA, 0x88ED, 0x0C02)  # framebuffer to draw to, to read from, pixel-pack buffer, read buffer


def gl(name, *arguments):
    address = SDL.SDL_GL_GetProcAddress(f"gl{name}".encode())
    return ctypes.CFUNCTYPE(ctypes.c_uint)(address)(*arguments)


def integer(name):
    value = ctypes.c_int()
    gl("GetIntegerv", name, ctypes.byref(value))
    return value.value


def generated(kind):
    name = ctypes.c_uint()
    gl(f"Gen{kind}", 1, ctypes.byref(name))
    return name.value


def clear(red, green, blue):
    gl("ClearColor", *(ctypes.c_float(part) for part in (red, green, blue, 1.0)))
    gl("Clear", COLOUR_AND_DEPTH)


def main():
    width, height = map(int, sys.argv[1:])
    SDL.SDL_Init(VIDEO)
    SDL.SDL_GL_SetAttribute(DEPTH_SIZE, 24)
    window = SDL.SDL_CreateWindow(b"state", 0, 0, width, height, OPENGL)
    SDL.SDL_GL_CreateContext(window)
    gl("ClearDepth", ctypes.c_double(0.5))
    renderbuffer, framebuffer, buffer = generated("Renderbuffers"), generated("Framebuffers"), generated("Buffers")
    gl("BindRenderbuffer", RENDERBUFFER, renderbuffer)
    gl("RenderbufferStorage", RENDERBUFFER, RGBA8, width, height)
    gl("BindBuffer", PACK_BUFFER, buffer)
    gl("BufferData", PACK_BUFFER, ctypes.c_size_t(4 * 77 * (height + 3)), None, STREAM_READ)
    for name, value in PACK.items():
        gl("PixelStorei", name, value)
    for _ in range(2):
        gl("BindFramebuffer", FRAMEBUFFER, 0)
        clear(0.2, 0.4, 0.8)
        gl("BindFramebuffer", FRAMEBUFFER, framebuffer)
        gl("FramebufferRenderbuffer", FRAMEBUFFER, ATTACHMENT_0, RENDERBUFFER, renderbuffer)
        gl("ReadBuffer", ATTACHMENT_0)
        clear(1.0, 0.0, 0.0)
        names = (*PACK, *BINDINGS)
        before = [integer(name) for name in names]
        SDL.SDL_GL_SwapWindow(window)
        after = [integer(name) for name in names]
        expected = [*PACK.values(), framebuffer, framebuffer, buffer, ATTACHMENT_0]
        if not before == after == expected or gl("GetError"):
            sys.exit(f"{before} before, {after} after, not {expected}")


if __name__ == "__main__":
    main()
