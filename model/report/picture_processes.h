#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "formats/image.h"

namespace metabuffer {

/// Does something with pictures, such as encoding them, in separate processes while this one goes on. A process holds a
/// fixed number of pictures, in memory that is shared with it, so that memory does not grow with the number of pictures.
class PictureProcesses {
  public:
    /// What is done with the picture of that name. True if the caller is to have the picture back.
    using Work = std::function<bool(const std::string& name, const ColourImage& picture)>;
    /// Receives in this process the pictures that `work` gives back.
    using GivenBack = std::function<void(const std::string& name, const ColourImage& picture)>;

    struct Extent {
        std::size_t processes = 0;      ///< the most that are started; fewer if this computer allows no more
        std::size_t pictures_each = 1;  ///< the most that a process holds, at least 1
        std::size_t pixels_of_largest = 0;  ///< a larger picture is done by take() itself
    };

    /// work: what the processes call, or take() itself without processes; what `work` needs is loaded before. given_back:
    /// may be empty if `work` gives none.
    PictureProcesses(const Extent& extent, Work work, GivenBack given_back = {});
    PictureProcesses(const PictureProcesses&) = delete;
    PictureProcesses& operator=(const PictureProcesses&) = delete;
    /// Ends processes that still work; their pictures are lost.
    ~PictureProcesses();

    /// Waits for a process that has room, and hands it the picture. Each process does its pictures in the order of these
    /// calls. A picture that a process cannot do because memory is short or it was killed is done here. Throws the
    /// OutputError or InputError that `work` threw for this picture or for an earlier one.
    void take(const std::string& name, const ColourImage& picture);
    /// Waits for all pictures. Throws as take().
    void finish();

  private:
    class Worker;

    Worker* worker_with_room();
    void wait_for_any();
    void settle_oldest(Worker& worker) const;
    void do_here(const std::string& name, const ColourImage& picture) const;

    Work work_;
    GivenBack given_back_;
    std::size_t pixels_of_largest_;
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace metabuffer
