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
/// Returns the same images. The processes live as long as one of the images does and as long as there is something to
/// read. An image that a process cannot read because memory is short or it was killed is read by the caller of pixels(),
/// and a child of this process reads all its images itself. So an error is always a fault of the image's file.
std::vector<std::shared_ptr<const StoredImage>> read_ahead(
    std::vector<std::shared_ptr<const StoredImage>> images, std::size_t processes);

}  // namespace metabuffer
