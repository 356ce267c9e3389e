#include "images/image_codec.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <thread>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "images/image_module.h"

namespace metabuffer {
namespace {

[[noreturn]] void fail_to_load() {
    const char* why = dlerror();
    throw InputError(text::one_line(std::string("images can be neither read nor written: ") +
                                    (why == nullptr ? "no reason given" : why) +
                                    "; install metabuffer again, or build all of it"));
}

/// Whether this process may start `processes` more, all alive at the same time.
bool can_start(unsigned processes) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return false;
    std::vector<pid_t> children;
    pid_t child = 0;
    while (children.size() < processes && (child = fork()) > 0) children.push_back(child);
    if (child == 0 && children.size() < processes) {
        // Waits until the parent has closed its end, in whatever way.
        close(ends[1]);
        char nothing = 0;
        static_cast<void>(!read(ends[0], &nothing, 1));
        _exit(0);
    }
    close(ends[0]);
    close(ends[1]);
    for (const pid_t started : children) {
        while (waitpid(started, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    return children.size() == processes;
}

/// When OpenImageIO's libraries are loaded, one starts a thread for each processor and others start a few. If they may
/// not, one waits for ever, with all signals blocked.
void check_threads() {
    constexpr unsigned kOthers = 6;
    if (!can_start(std::thread::hardware_concurrency() + kOthers)) {
        throw InputError(
            "metabuffer: this computer refuses the threads that OpenImageIO's libraries start; raise its "
            "limit on processes");
    }
}

const ImageCodec& load_codec() {
    check_threads();
    // By its name: the program says where its modules are, built or installed. Never unloaded, since OpenImageIO's
    // libraries start threads.
    void* module = dlopen(kImageModuleFile, RTLD_LAZY | RTLD_LOCAL);
    if (module == nullptr) fail_to_load();
    void* entry = dlsym(module, kImageModuleEntry);
    if (entry == nullptr) fail_to_load();
    return *reinterpret_cast<ImageModuleEntry*>(entry)();
}

class ImagesHere final : public ImageSource {
  public:
    ImageSize size(const ImageFiles& files) const override { return image_codec().size(files); }
    PixelImage load(const ImageFiles& files, DepthFormat format, const DepthRange& range) const override {
        return image_codec().load(files, format, range);
    }
};

}  // namespace

const ImageCodec& image_codec() {
    static const ImageCodec& codec = load_codec();
    return codec;
}

std::shared_ptr<const ImageSource> images_here() { return std::make_shared<const ImagesHere>(); }

}  // namespace metabuffer
