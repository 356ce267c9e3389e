#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "formats/stored_image.h"

namespace metabuffer {

/// Reads images in separate processes before they are needed, while this process goes on. Each process holds one image
/// at a time, in memory that is shared with it, so that memory does not grow with the number of images.
///
/// images: in the order of their use. processes: the most that are started; fewer if this computer allows no more.
///
/// Returns the same images; the processes live as long as one of them does and as long as there is something to read.
/// What a process cannot do because memory is short or since it was killed, the caller of pixels() does itself, and a
/// child of this process does all itself. So only an image's own fault is an error, the one of the original image.
std::vector<std::shared_ptr<const StoredImage>> read_ahead(
    std::vector<std::shared_ptr<const StoredImage>> images, std::size_t processes);

}  // namespace metabuffer
