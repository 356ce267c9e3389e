#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "formats/image.h"
#include "scenario/scenario.h"
#include "simulation/frame_shown.h"
#include "tools/charts/value_json.h"

namespace metabuffer::charts {

/// PNG files for a page. A file that is added again is kept once.
class PagePictures {
  public:
    /// Returns the file's number, by which the page's script finds it.
    std::size_t add(std::shared_ptr<const std::string> png);
    const std::vector<std::shared_ptr<const std::string>>& files() const { return files_; }

  private:
    std::vector<std::shared_ptr<const std::string>> files_;
    std::map<const std::string*, std::size_t> numbers_;
};

/// The pictures that displays show in a run, for a page. If all of them would take more than `most_bytes`, only every
/// second frame is kept, then every fourth, and so on. The first frame is always kept.
class ShownPictures {
  public:
    ShownPictures(const Scenario& scenario, std::size_t most_bytes)
        : displays_(static_cast<std::size_t>(scenario.displays.count())), most_bytes_(most_bytes) {}

    /// Throws OutputError.
    void take(const DisplayedFrame& displayed);

    int stride() const { return stride_; }
    std::size_t bytes() const { return bytes_; }
    /// The kept frames, with the number of each display's picture.
    Json json(PagePictures& pictures) const;
    bool has(int frame) const { return frames_.count(frame) > 0; }

  private:
    using Png = std::shared_ptr<const std::string>;

    void count_bytes();

    std::size_t displays_;
    std::size_t most_bytes_;
    int stride_ = 1;
    std::size_t bytes_ = 0;
    std::map<int, std::vector<Png>> frames_;
};

/// What renderers contributed to the frames that a page shows: tables, and images. An image is two pictures, the colour
/// half and the depth half as they were on the link.
class Contributions {
  public:
    /// The scenario must outlive it.
    Contributions(const Scenario& scenario, std::size_t most_bytes)
        : scenario_(scenario), room_(most_bytes) {}

    /// Throws OutputError.
    Json frame_json(const std::vector<int>& pairs, PagePictures& pictures);
    /// Every image and every table that the frames refer to.
    Json images_json() const { return images_; }
    Json tables_json() const { return tables_; }
    std::size_t images_left_out() const { return images_left_out_; }

  private:
    std::size_t image_number(const PixelImage& image, std::shared_ptr<const PixelImage> copy,
                             PagePictures& pictures);
    std::size_t table_number(const ViewportTable& rows);

    const Scenario& scenario_;
    std::size_t room_;
    Json images_ = Json::array();
    Json tables_ = Json::array();
    std::map<const PixelImage*, std::size_t> image_numbers_;
    std::map<std::string, std::size_t> table_numbers_;
    std::vector<std::shared_ptr<const PixelImage>>
        copies_;  ///< kept so that no two images have the same address
    std::size_t images_left_out_ = 0;
};

}  // namespace metabuffer::charts
