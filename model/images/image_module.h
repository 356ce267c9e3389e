#pragma once

#include "images/image_codec.h"

namespace metabuffer {

/// The module that the image service loads (image_service.h), and the function in it that returns its codec.
constexpr const char* kImageModuleFile = "metabuffer_images.so";
constexpr const char* kImageModuleEntry = "metabuffer_image_module";
using ImageModuleEntry = const ImageCodec*();

}  // namespace metabuffer

extern "C" metabuffer::ImageModuleEntry metabuffer_image_module;
