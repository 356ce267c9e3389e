#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/image_files.h"

/// Which channels of a file are the colours, alpha and Z of an image. Nothing here reads a file.
namespace metabuffer::image_channels {

constexpr int kNoChannel = -1;

/// The channels that an image file keeps in one part: OpenEXR files may have several, which have names.
struct Part {
    std::string name;
    std::vector<std::string> channels;
};

/// Of a layer: channels such as "diffuse.R", "diffuse.G" and "diffuse.B", or R, G and B in a part of that name. In a grey
/// image all three are the same channel.
struct Colours {
    int part = 0;
    int red = kNoChannel;
    int green = kNoChannel;
    int blue = kNoChannel;
    int alpha = kNoChannel;
};

struct Depth {
    int part = 0;
    int channel = kNoChannel;
    /// Z may be R, G and B, each the same or together (DepthBits); `channel` is R then.
    std::optional<Colours> colours = std::nullopt;
};

/// The colours of the layer. Without a layer, the first of these that the file has: channels R, G and B; those of the only
/// layer that has them, also r, g and b; the grey of Y. Throws InputError, without the file's name, if there is none or
/// more than one.
Colours find_colours(const std::vector<Part>& parts, const std::optional<std::string>& layer);

/// Z in an image's own file: of the layer, which may also be a channel. Without a layer: Z of the colours' layer, else the
/// only channel that is called Z, Depth or depth, or the only one of these that depth is named for. Z that comes with X
/// or Y is a vector's. Throws as find_colours does.
Depth find_depth(const std::vector<Part>& parts, const std::optional<std::string>& layer,
                 const Colours& colours);

/// Z in a file of its own, which may also be the only channel, grey, or R, G and B. Throws as find_colours does.
Depth find_depth_alone(const std::vector<Part>& parts, const std::optional<std::string>& layer);

}  // namespace metabuffer::image_channels
