#pragma once

#include "formats/viewport_table.h"

namespace metabuffer {

/// Where a renderer's image lies in the global display space: the raster position of its top left pixel and
/// the replication factor. Any position is allowed, also partly or wholly outside the wall.
struct Viewport {
    int x = 0;
    int y = 0;
    int multiple = 1;
};

/// The joint display space: a grid of equal rasters, numbered from 1, row by row.
struct DisplayWall {
    int columns = 1;
    int rows = 1;
    int raster_width_pixels = 0;  ///< of one display, supersampling included
    int raster_height_pixels = 0;
    int gap_x_pixels = 0;  ///< raster pixels between neighbouring displays that nobody sees
    int gap_y_pixels = 0;
};

/// The host's side of section 5: the table that shows an image at the viewport, one row for each display that the image
/// touches. A source pixel that straddles two displays goes to both. Where composers smooth a magnified image, each row
/// has an apron: a source row and column more on every side on which the image goes on, so that the displays show to the
/// bit what one large display would. Throws std::invalid_argument if multiple is not 1..255 or a coordinate of a row does
/// not fit its 16-bit field.
ViewportTable split_viewport(const Viewport& viewport, int image_width_pixels, int image_height_pixels,
                             const DisplayWall& wall, Smoothing smoothing = Smoothing::kReplicate);

}  // namespace metabuffer
