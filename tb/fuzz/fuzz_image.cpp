// libFuzzer: whatever bytes an image file holds, the loader returns pixels or reports on one line what is wrong with
// the file. The libraries that it asks print nothing themselves. scripts/fuzz runs it.

#include <OpenImageIO/imageio.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "expectations.h"
#include "formats/pixel.h"
#include "host/errors.h"
#include "images/image_file.h"
#include "images/image_reader.h"
#include "support/scratch_directory.h"

namespace {

using namespace metabuffer;

/// The folder that the files are in: one for each process, since several may run side by side.
const test::ScratchDirectory& folder() {
    static const test::ScratchDirectory scratch;
    return scratch;
}

/// A file's first bytes give its format, except for Targa, whose uncompressed true-colour files begin with these.
const char* file_name(std::string_view bytes) {
    using namespace std::string_view_literals;
    return bytes.substr(0, 3) == "\0\0\x02"sv ? "image.tga" : "image";
}

/// Captures what is written to the standard output and error while it lives.
class OutputCapture {
  public:
    OutputCapture() {
        for (std::size_t i = 0; i < kStreams.size(); ++i) {
            saved_[i] = dup(kStreams[i]);
            EXPECT(saved_[i] >= 0 && dup2(caught_, kStreams[i]) >= 0);
        }
    }
    OutputCapture(const OutputCapture&) = delete;
    OutputCapture& operator=(const OutputCapture&) = delete;
    ~OutputCapture() {
        restore();
        close(caught_);
    }
    /// What was written so far; nothing more is captured.
    std::string text() {
        restore();
        std::string text(static_cast<std::size_t>(lseek(caught_, 0, SEEK_END)), '\0');
        EXPECT(pread(caught_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()));
        return text;
    }

  private:
    static constexpr std::array<int, 2> kStreams{STDOUT_FILENO, STDERR_FILENO};

    void restore() {
        for (std::size_t i = 0; i < kStreams.size(); ++i) {
            if (saved_[i] < 0) continue;
            std::fflush(i == 0 ? stdout : stderr);
            dup2(saved_[i], kStreams[i]);
            close(saved_[i]);
            saved_[i] = -1;
        }
    }

    int caught_ = memfd_create("caught", 0);
    std::array<int, 2> saved_{-1, -1};
};

/// An image of a size that the loader accepts, but large: it takes long and shows nothing new. One that is larger than
/// any valid one is not skipped, for it must be refused.
bool is_large(const std::filesystem::path& file) {
    constexpr std::uint64_t kLargeBytes = 4'000'000;
    try {
        const std::uint64_t bytes = open_image_file(file).input->spec().image_bytes(true);
        return bytes > kLargeBytes && bytes <= kLargestImageBytes;
    } catch (const InputError&) {
        return false;
    }
}

/// OpenEXR allocates as much as an attribute says to hold, up to 2 GB, before it finds that the file is shorter. This
/// is not a failure, but it would take all the time.
bool has_long_attribute(std::string_view bytes) {
    constexpr std::size_t kFirstAttribute = 8;
    constexpr std::uint32_t kLongBytes = 1U << 20U;
    if (bytes.substr(0, 4) != "\x76\x2f\x31\x01") return false;
    std::size_t at = kFirstAttribute;
    while (at < bytes.size() && bytes[at] != '\0') {
        at = bytes.find('\0', at);  // behind the name, then behind the type
        if (at != std::string_view::npos) at = bytes.find('\0', at + 1);
        std::uint32_t size = 0;
        if (at == std::string_view::npos || bytes.size() - ++at < sizeof size) return false;
        std::memcpy(&size, bytes.data() + at, sizeof size);
        if (size > kLongBytes) return true;
        at += sizeof size + size;
    }
    return false;
}

void check_pixels(const PixelImage& image, DepthFormat format) {
    EXPECT(kImageSidePixels.contains(image.width_pixels));
    EXPECT(kImageSidePixels.contains(image.height_pixels));
    EXPECT(image.values.size() ==
           static_cast<std::size_t>(image.width_pixels) * static_cast<std::size_t>(image.height_pixels));
    for (const Pixel& pixel : image.values) {
        EXPECT(pixel.z() <= far_z(format));
        EXPECT(layout_of(format).has_alpha() || pixel.a() == 255);
    }
}

/// libpng prints its own messages, too, and OpenImageIO cannot stop it. No other library does.
std::string without_libpng_lines(const std::string& text) {
    std::istringstream lines(text);
    std::string rest;
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("libpng ", 0) != 0) rest += line + '\n';
    }
    return rest;
}

struct Outcome {
    std::optional<PixelImage> image;
    std::string complaint;
};

Outcome load(const ImageFiles& files, DepthFormat format) {
    Outcome outcome;
    OutputCapture capture;
    try {
        outcome.image = load_image(files, format, {0.0, 100.0});
    } catch (const InputError& error) {
        outcome.complaint = error.what();
    }
    const std::string said = without_libpng_lines(capture.text());
    if (!said.empty()) metabuffer::fuzz::fail("a library wrote: " + said);
    if (outcome.image.has_value()) {
        check_pixels(*outcome.image, format);
    } else {
        metabuffer::fuzz::expect_one_clear_line(InputError(outcome.complaint));
    }
    return outcome;
}

std::filesystem::path colour_for_depth(int width, int height) {
    const std::filesystem::path file = folder() / "colour.ppm";
    std::ofstream output(file, std::ios::binary);
    output << "P6 " << width << ' ' << height << " 255\n"
           << std::string(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, '\x40');
    return file;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    if (has_long_attribute(bytes)) return 0;
    const std::filesystem::path file = folder().write(file_name(bytes), bytes);
    {
        OutputCapture library_words_are_looked_at_below;
        if (is_large(file)) return 0;
    }
    ImageFiles files{file};
    Outcome outcome = load(files, DepthFormat::kA8Z16);
    if (outcome.complaint.find("and no Z") != std::string::npos) {
        files.z = 50.0;
        outcome = load(files, DepthFormat::kA8Z16);
    }
    if (outcome.image.has_value()) {
        load(files, DepthFormat::kZ24);
        return 0;
    }
    if (outcome.complaint.find("has the channels") == std::string::npos) return 0;
    // No colours: perhaps a depth file, for an image of the size that the kept inputs have.
    constexpr int kSeedWidth = 4;
    constexpr int kSeedHeight = 3;
    static const std::filesystem::path colour = colour_for_depth(kSeedWidth, kSeedHeight);
    load({colour, file}, DepthFormat::kA8Z16);
    load({colour, file}, DepthFormat::kZ24);
    return 0;
}

/// libpng leaves its readers by a long jump, past the code that would free their memory.
extern "C" const char*
__asan_default_options() {  // NOLINT(bugprone-reserved-identifier): the sanitizer's name
    return "detect_leaks=0";
}

/// A library's messages are captured at the standard error, where libFuzzer prints, too. So libFuzzer and complaints()
/// use a copy.
extern "C" int LLVMFuzzerInitialize(int* argument_count, char*** arguments) {
    metabuffer::fuzz::complaints() = fdopen(dup(STDERR_FILENO), "w");
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    static char option[] = "-close_fd_mask=2";
    static std::vector<char*> extended(*arguments, *arguments + *argument_count);
    extended.push_back(option);
    *argument_count = static_cast<int>(extended.size());
    extended.push_back(nullptr);
    *arguments = extended.data();
    return 0;
}
