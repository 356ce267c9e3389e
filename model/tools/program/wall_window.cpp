#include "tools/program/wall_window.h"

#if METABUFFER_HAS_SDL
#include <SDL2/SDL.h>
#include <dlfcn.h>

#include <cstdint>
#include <cstdlib>
#include <type_traits>
#include <utility>
#endif

namespace metabuffer {

#if METABUFFER_HAS_SDL
namespace {

/// The functions that are used of SDL2.
struct Sdl {
    decltype(&SDL_Init) init = nullptr;
    decltype(&SDL_Quit) quit = nullptr;
    decltype(&SDL_GetError) error = nullptr;
    decltype(&SDL_SetHint) set_hint = nullptr;
    decltype(&SDL_CreateWindow) create_window = nullptr;
    decltype(&SDL_DestroyWindow) destroy_window = nullptr;
    decltype(&SDL_SetWindowTitle) set_title = nullptr;
    decltype(&SDL_SetWindowSize) set_size = nullptr;
    decltype(&SDL_GetWindowSurface) surface = nullptr;
    decltype(&SDL_UpdateWindowSurface) update = nullptr;
    decltype(&SDL_CreateRGBSurfaceFrom) surface_of = nullptr;
    decltype(&SDL_FreeSurface) free_surface = nullptr;
    decltype(&SDL_UpperBlitScaled) blit = nullptr;
    decltype(&SDL_PollEvent) poll_event = nullptr;

    /// False if the library or a function of it is not there.
    bool load() {
        void* const library = dlopen("libSDL2-2.0.so.0", RTLD_NOW | RTLD_LOCAL);
        if (library == nullptr) return false;
        const auto find = [library](const char* name, auto& function) {
            function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
            return function != nullptr;
        };
        return find("SDL_Init", init) && find("SDL_Quit", quit) && find("SDL_GetError", error) &&
               find("SDL_SetHint", set_hint) && find("SDL_CreateWindow", create_window) &&
               find("SDL_DestroyWindow", destroy_window) && find("SDL_SetWindowTitle", set_title) &&
               find("SDL_SetWindowSize", set_size) && find("SDL_GetWindowSurface", surface) &&
               find("SDL_UpdateWindowSurface", update) && find("SDL_CreateRGBSurfaceFrom", surface_of) &&
               find("SDL_FreeSurface", free_surface) && find("SDL_UpperBlitScaled", blit) &&
               find("SDL_PollEvent", poll_event);
    }
};

class SdlWindow final : public WallWindow {
  public:
    SdlWindow(const Sdl& sdl, std::string title) : sdl_(sdl), title_(std::move(title)) {}
    ~SdlWindow() override {
        if (window_ != nullptr) sdl_.destroy_window(window_);
        sdl_.quit();
    }

    bool make() {
        constexpr int kFirstWidth = 640;
        constexpr int kFirstHeight = 480;
        window_ = sdl_.create_window(title_.c_str(), static_cast<int>(SDL_WINDOWPOS_CENTERED),
                                     static_cast<int>(SDL_WINDOWPOS_CENTERED), kFirstWidth, kFirstHeight,
                                     SDL_WINDOW_RESIZABLE);
        return window_ != nullptr;
    }

    void show(const ColourImage& picture, const ColourImage& marked, const std::string& state) override {
        if (picture_.values.empty()) sdl_.set_size(window_, picture.width_pixels, picture.height_pixels);
        picture_ = picture;
        marked_ = marked;
        state_ = state;
        name_window();
        paint();
    }

    bool poll() override {
        bool open = true;
        for (SDL_Event event; sdl_.poll_event(&event) != 0;) {
            if (event.type == SDL_QUIT) open = false;
            if (event.type == SDL_WINDOWEVENT) paint();
            if (event.type != SDL_KEYDOWN) continue;
            const SDL_Keycode key = event.key.keysym.sym;
            if (key == SDLK_q || key == SDLK_ESCAPE) open = false;
            if (key != SDLK_w) continue;
            marks_ = !marks_;
            name_window();
            paint();
        }
        return open;
    }

  private:
    void name_window() {
        sdl_.set_title(window_, (title_ + state_ + (marks_ ? ", wrong pixels marked" : "")).c_str());
    }

    void paint() {
        ColourImage& shown = marks_ ? marked_ : picture_;
        SDL_Surface* const surface = sdl_.surface(window_);
        if (shown.values.empty() || surface == nullptr) return;
        constexpr int kBits = 32;
        SDL_Surface* const image = sdl_.surface_of(
            shown.values.data(), shown.width_pixels, shown.height_pixels, kBits,
            static_cast<int>(sizeof(std::uint32_t)) * shown.width_pixels, 0xFF0000, 0xFF00, 0xFF, 0);
        if (image == nullptr) return;
        sdl_.blit(image, nullptr, surface, nullptr);
        sdl_.free_surface(image);
        sdl_.update(window_);
    }

    Sdl sdl_;
    std::string title_;
    std::string state_;
    SDL_Window* window_ = nullptr;
    ColourImage picture_;
    ColourImage marked_;
    bool marks_ = false;
};

}  // namespace

std::unique_ptr<WallWindow> WallWindow::open(const std::string& title, std::string& why_not) {
    const auto has = [](const char* variable) { return std::getenv(variable) != nullptr; };
    if (!has("DISPLAY") && !has("WAYLAND_DISPLAY") && !has("SDL_VIDEODRIVER")) {
        why_not = "there is no screen (DISPLAY is not set)";
        return nullptr;
    }
    Sdl sdl;
    if (!sdl.load()) {
        why_not = "SDL2 is not installed (Debian's libsdl2-2.0-0)";
        return nullptr;
    }
    sdl.set_hint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    if (sdl.init(SDL_INIT_VIDEO) != 0) {
        why_not = std::string("SDL2 says: ") + sdl.error();
        return nullptr;
    }
    auto window = std::make_unique<SdlWindow>(sdl, title);
    if (window->make()) return window;
    why_not = std::string("SDL2 says: ") + sdl.error();
    return nullptr;
}
#else
std::unique_ptr<WallWindow> WallWindow::open(const std::string& /*title*/, std::string& why_not) {
    why_not = "it was built without SDL2's headers (Debian's libsdl2-dev)";
    return nullptr;
}
#endif

}  // namespace metabuffer
