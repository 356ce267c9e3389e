#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "formats/image.h"

namespace metabuffer {

/// Encodes pictures in separate processes while this one goes on. A process holds one picture at a time, in memory that
/// is shared with it, so that memory does not grow with the number of pictures.
class PictureProcesses {
  public:
    /// Encodes a picture and writes it to the file of that name.
    using Encode = std::function<void(const std::string& name, const ColourImage& picture)>;

    /// processes: the most that are started; fewer if this computer allows no more. With none, take() encodes by
    /// itself. most_pixels: of one picture; take() encodes a larger one by itself.
    /// encode: what the processes call; what it needs is loaded before.
    PictureProcesses(std::size_t processes, std::size_t most_pixels, Encode encode);
    PictureProcesses(const PictureProcesses&) = delete;
    PictureProcesses& operator=(const PictureProcesses&) = delete;
    /// Ends processes that still work; their pictures are lost.
    ~PictureProcesses();

    /// Hands a picture to an idle process, waiting until there is one. If a process cannot do it because memory is
    /// short or since it was killed, it is done here. Throws the OutputError or InputError that `encode` threw for this
    /// picture or for an earlier one.
    void take(const std::string& name, const ColourImage& picture);
    /// Waits for all pictures. Throws as take().
    void finish();

  private:
    class Worker;

    Worker* idle_worker();
    void wait_for_any();
    void settle(Worker& worker) const;

    Encode encode_;
    std::size_t most_pixels_;
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace metabuffer
