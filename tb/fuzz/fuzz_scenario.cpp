// libFuzzer: whatever a scenario file holds, the reader returns a scenario or says on one line what is wrong
// with it. scripts/fuzz runs it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "expectations.h"
#include "host/errors.h"
#include "scenario/scenario_loader.h"
#include "support/scratch_directory.h"

namespace {

/// A folder for the scenarios' images and colour tables, with tiny ones in it, so that the code after them is reached, and
/// quickly.
class ImageFolder {
  public:
    ImageFolder() {
        constexpr int kPixels = 20 * 3;
        std::string colour = "P3 20 3 255\n";
        std::string depth = "P2 20 3 255\n";
        for (int i = 0; i < kPixels; ++i) {
            colour += std::to_string(i) + ' ' + std::to_string(2 * i) + ' ' + std::to_string(3 * i) + '\n';
            depth += std::to_string(4 * i) + '\n';
        }
        scratch_.write("a.ppm", colour);
        scratch_.write("z.pgm", depth);
        std::string table;
        for (int v = 0; v < 256; ++v) table += "1," + std::to_string(v) + ",3\n";
        scratch_.write("t.csv", table);
    }
    const std::filesystem::path& path() const { return scratch_.path(); }

  private:
    metabuffer::test::ScratchDirectory scratch_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const ImageFolder folder;
    const std::string text(reinterpret_cast<const char*>(data), size);
    // A path that leaves the folder could name a device that never ends.
    if (text.find('/') != std::string::npos) return 0;
    try {
        metabuffer::parse_scenario(text, "fuzz.yaml", folder.path());
    } catch (const metabuffer::InputError& error) {
        metabuffer::fuzz::expect_one_clear_line(error);
    }
    return 0;
}
