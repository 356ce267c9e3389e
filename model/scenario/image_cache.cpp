#include "scenario/image_cache.h"

#include "host/errors.h"
#include "scenario/colour_table_file.h"

namespace metabuffer::input {
namespace {

/// The pixels of an image whose headers gave this size.
ReadImage read_pixels(const ImageSource& source, const ImageCache::Key& key, ImageSize size,
                      const ImageCache::Fail& fail) {
    const auto& [files, format, reading] = key;
    ReadImage image;
    try {
        image = source.load(files, format, reading);
        if (image.width_pixels != size.width_pixels || image.height_pixels != size.height_pixels) {
            throw InputError(files.image.string() + ": has changed its size since the scenario was read");
        }
    } catch (const InputError& error) {
        fail(error.what());
    }
    return image;
}

}  // namespace

const std::shared_ptr<const ColourTable>& ImageCache::colour_table_of(const std::filesystem::path& file) {
    if (const auto known = colour_tables_.find(file); known != colour_tables_.end()) return known->second;
    return colour_tables_.emplace(file, std::make_shared<const ColourTable>(read_colour_table(file)))
        .first->second;
}

const std::shared_ptr<const StoredImage>& ImageCache::image_of(const Key& key, Fail fail_later) {
    if (const auto known = images_.find(key); known != images_.end()) return known->second;
    const auto failed = failures_.find(key);
    if (failed != failures_.end() && failed->second.is_lasting) throw InputError(failed->second.message);
    try {
        const ImageSize size = source_->size(std::get<ImageFiles>(key));
        StoredImage::Read read = [key, size, source = source_, fail = std::move(fail_later)] {
            return read_pixels(*source, key, size, fail);
        };
        return images_.emplace(key, std::make_shared<const StoredImage>(size, std::move(read))).first->second;
    } catch (const InputError& error) {
        const bool is_lasting = failed != failures_.end() && failed->second.message == error.what();
        failures_[key] = {error.what(), is_lasting};
        throw;
    }
}

}  // namespace metabuffer::input
