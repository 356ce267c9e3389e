#pragma once

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>

#include "formats/image.h"

namespace metabuffer {

/// An image file that is open for reading. Samples are unconverted; the attribute oiio:UnassociatedAlpha says whether R, G
/// and B are multiplied by alpha.
struct OpenImageFile {
    enum class Windows : std::uint8_t {
        kNone,        ///< the format has no display window
        kSized,       ///< a display window, whose position means nothing
        kPositioned,  ///< a display window with a position
    };
    std::unique_ptr<OIIO::ImageInput> input;
    int orientation = 1;  ///< as EXIF numbers them
    Windows windows = Windows::kNone;
    bool has_parts = false;  ///< the file's images belong together; if not, only the first counts
};

/// Opens an image in one of the formats that renderers and frame grabbers write, recognized by its first bytes and not
/// by its name (only Targa, which has no such bytes, by its name). The readers of other formats are never called: some
/// readers of OpenImageIO 2.4 write beyond their memory, the one for ICO even with a file without a fault. Throws
/// InputError naming the file and why it cannot be read.
OpenImageFile open_image_file(const std::filesystem::path& file);

/// Throws the InputError that names the file and its size unless both sides lie in kImageSidePixels.
void check_image_size(const std::filesystem::path& file, std::int64_t width_pixels,
                      std::int64_t height_pixels);

/// Bytes that an image's channels may take once unpacked: those of R, G, B, A and Z as doubles at the largest size. A
/// TIFF file of 130 bytes can name thousands of channels, and its reader allocates and clears strips of them all.
constexpr std::uint64_t kLargestImageBytes =
    std::uint64_t{kImageSidePixels.high * kImageSidePixels.high} * 5 * sizeof(double);

/// Throws the InputError that names a file and says what is wrong with it.
[[noreturn]] void fail_image(const std::filesystem::path& file, const std::string& message);

/// Throws the InputError of a file that cannot be opened, or read to its end, as an image. why: the reader's message,
/// which may be empty.
[[noreturn]] void fail_unreadable_image(const std::filesystem::path& file, const std::string& why);

/// Calls one of OpenImageIO's readers. What it throws is the fault of a damaged file, except for a lack of memory.
template <typename Question>
auto ask_reader(const std::filesystem::path& file, Question question) {
    try {
        return question();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        fail_unreadable_image(file, error.what());
    }
}

}  // namespace metabuffer
