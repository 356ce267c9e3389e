#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "images/image_codec.h"

namespace metabuffer {

/// The codec of the program. It works in a separate process, which is started for the first image and loads OpenImageIO and
/// its libraries. If these start threads, wait for ever or crash, this process goes on. A program that uses OpenImageIO
/// itself makes this object first: OpenImageIO's threads are missing in a process that is forked later.
///
/// This process and each child of it have a connection of their own. At the other end of each is a child of the process
/// that has loaded the libraries, so images can be read and written at the same time.
///
/// All functions throw InputError if the libraries cannot be loaded within kMostLoadingSeconds, or if the process ends
/// twice over the same image; std::bad_alloc if it has too little memory for the image.
class ImageService final : public ImageCodec {
  public:
    /// Of wall time, and of the processor's: more than enough for a computer that reads the libraries from the network.
    static constexpr int kMostLoadingSeconds = 20;
    static constexpr int kMostLoadingProcessorSeconds = 5;

    /// Starts the process, which children of this one use, too.
    ImageService();
    /// Ends the process.
    ~ImageService() override;

    ImageSize size(const ImageFiles& files) const override;
    ReadImage load(const ImageFiles& files, DepthFormat format, const ImageReading& reading) const override;
    std::string png(const ColourImage& image, const std::filesystem::path& file,
                    const std::string& description) const override;
    std::string colour_tiff(const PixelImage& image, const std::filesystem::path& file) const override;
    std::string depth_tiff(const PixelImage& image, DepthFormat format,
                           const std::filesystem::path& file) const override;

  private:
    class Stream;
    class Process;
    class Server;
    enum class Operation : std::uint8_t;
    struct EncodingRequest;

    void ask(const std::filesystem::path& file, const std::function<void(Stream&)>& question) const;
    template <typename Value>
    std::string encoded(const EncodingRequest& request, const Raster<Value>& image) const;
    Stream& stream() const;
    Stream connect() const;
    void give_up() const;

    mutable std::unique_ptr<Process> process_;
    mutable std::unique_ptr<Stream> stream_;
    mutable pid_t connected_ = 0;  ///< the process that stream_ is of
};

}  // namespace metabuffer
