#include "images/image_encoder.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <limits>
#include <vector>

#include "host/output_file.h"
#include "images/rescaled.h"

namespace metabuffer {
namespace {

/// From 0 to 9. Writing the pictures takes longer than level tlm takes to make them. A higher compression takes several
/// times as long and saves little.
constexpr int kPngCompressionLevel = 1;

/// libpng's PNG_FILTER_SUB: each sample minus its left neighbour. Trying all filters on each row takes twice as long
/// and makes files smaller by a sixth at most.
constexpr int kPngFilter = 0x10;

/// The file that holds the samples, pixel by pixel. `file` is what an error names.
template <typename Sample>
std::string encoded(const char* format, const OIIO::ImageSpec& spec, const std::vector<Sample>& samples,
                    const std::filesystem::path& file) {
    const auto output = OIIO::ImageOutput::create(format);
    if (output == nullptr) fail_to_write(file, OIIO::geterror());
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    if (!output->set_ioproxy(&memory))
        fail_to_write(file, std::string(format) + " cannot be written to memory");
    if (!output->open(file.string(), spec) ||
        !output->write_image(OIIO::BaseTypeFromC<Sample>::value, samples.data()) || !output->close()) {
        fail_to_write(file, output->geterror());
    }
    return {bytes.begin(), bytes.end()};
}

template <typename Sample, typename Value>
OIIO::ImageSpec specification(const Raster<Value>& image, const std::vector<std::string>& channels) {
    OIIO::ImageSpec spec(image.width_pixels, image.height_pixels, static_cast<int>(channels.size()),
                         OIIO::BaseTypeFromC<Sample>::value);
    spec.channelnames = channels;
    spec.alpha_channel = spec.channelindex("A");
    return spec;
}

template <typename Sample>
std::string encode_tiff(const PixelImage& image, const std::vector<std::string>& channels,
                        const std::vector<Sample>& samples, const std::filesystem::path& file) {
    OIIO::ImageSpec spec = specification<Sample>(image, channels);
    // The same image makes the same file, whenever it is written.
    spec.attribute("DateTime", "1970:01:01 00:00:00");
    return encoded("tiff", spec, samples, file);
}

/// Z as a share of the samples' full scale.
template <typename Sample>
std::string encode_depth(const PixelImage& image, std::uint32_t far, const std::filesystem::path& file) {
    std::vector<Sample> samples;
    samples.reserve(image.values.size());
    for (const Pixel pixel : image.values) {
        samples.push_back(static_cast<Sample>(rescaled(pixel.z(), far, std::numeric_limits<Sample>::max())));
    }
    return encode_tiff(image, {"Z"}, samples, file);
}

}  // namespace

// The specification holds geometry and description alone, no date and no software: the same picture makes the same file.
std::string encode_png(const ColourImage& image, const std::filesystem::path& file,
                       const std::string& description) {
    const std::vector<std::string> channels{"R", "G", "B"};
    std::vector<std::uint8_t> samples(image.values.size() * channels.size());
    auto* sample = samples.data();
    for (const std::uint32_t colour : image.values) {
        *sample++ = static_cast<std::uint8_t>(colour >> 16);
        *sample++ = static_cast<std::uint8_t>(colour >> 8);
        *sample++ = static_cast<std::uint8_t>(colour);
    }
    OIIO::ImageSpec spec = specification<std::uint8_t>(image, channels);
    spec.attribute("png:compressionLevel", kPngCompressionLevel);
    spec.attribute("png:filter", kPngFilter);
    if (!description.empty()) spec.attribute("ImageDescription", description);
    return encoded("png", spec, samples, file);
}

std::string encode_colour_tiff(const PixelImage& image, const std::filesystem::path& file) {
    const std::vector<std::string> channels{"R", "G", "B", "A"};
    std::vector<std::uint8_t> samples;
    samples.reserve(image.values.size() * channels.size());
    for (const Pixel pixel : image.values) {
        for (const std::uint8_t channel : {pixel.r(), pixel.g(), pixel.b(), pixel.a()}) {
            samples.push_back(channel);
        }
    }
    return encode_tiff(image, channels, samples, file);
}

std::string encode_depth_tiff(const PixelImage& image, DepthFormat format,
                              const std::filesystem::path& file) {
    const std::uint32_t far = far_z(format);
    return layout_of(format).z_bits <= 16 ? encode_depth<std::uint16_t>(image, far, file)
                                          : encode_depth<std::uint32_t>(image, far, file);
}

}  // namespace metabuffer
