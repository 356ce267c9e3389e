#include "images/image_codec.h"

#include <dlfcn.h>

#include <string>

#include "host/errors.h"
#include "host/text.h"
#include "images/image_module.h"

namespace metabuffer {
namespace {

[[noreturn]] void fail_to_load() {
    const char* why = dlerror();
    throw InputError(text::one_line(std::string("images can be neither read nor written: ") +
                                    (why == nullptr ? "no reason given" : why) +
                                    "; install metabuffer anew, or build it all"));
}

const ImageCodec& load_codec() {
    // By its name: the program says where its modules are, built or installed. Never unloaded, for OpenImageIO's
    // libraries start threads.
    void* module = dlopen(kImageModuleFile, RTLD_LAZY | RTLD_LOCAL);
    if (module == nullptr) fail_to_load();
    void* entry = dlsym(module, kImageModuleEntry);
    if (entry == nullptr) fail_to_load();
    return *reinterpret_cast<ImageModuleEntry*>(entry)();
}

}  // namespace

const ImageCodec& image_codec() {
    static const ImageCodec& codec = load_codec();
    return codec;
}

}  // namespace metabuffer
