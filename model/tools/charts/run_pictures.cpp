#include "tools/charts/run_pictures.h"

#include <set>
#include <utility>

#include "functional/functional_compositor.h"
#include "images/image_codec.h"

namespace metabuffer::charts {
namespace {

/// The picture's name in an error of the encoder.
constexpr const char* kInPage = "a picture of the page";

template <typename Bits>
std::string png_of_bits(const PixelImage& image, Bits bits) {
    ColourImage picture(image.width_pixels, image.height_pixels);
    for (std::size_t n = 0; n < picture.values.size(); ++n) picture.values[n] = bits(image.values[n]);
    return image_codec().png(picture, kInPage);
}

}  // namespace

std::size_t PagePictures::add(std::shared_ptr<const std::string> png) {
    const auto [entry, is_new] = numbers_.emplace(png.get(), files_.size());
    if (is_new) files_.push_back(std::move(png));
    return entry->second;
}

void ShownPictures::take(const DisplayedFrame& displayed) {
    if (displayed.frame % stride_ != 0) return;
    auto png = std::make_shared<const std::string>(image_codec().png(displayed.picture, kInPage));
    const auto d = static_cast<std::size_t>(displayed.display - 1);
    // A picture that does not change is stored once.
    const auto before = frames_.lower_bound(displayed.frame);
    const Png last = before == frames_.begin() ? nullptr : std::prev(before)->second[d];
    if (last != nullptr && *last == *png) {
        png = last;
    } else {
        bytes_ += png->size();
    }
    std::vector<Png>& pictures = frames_[displayed.frame];
    pictures.resize(displays_);
    // Other frames may share the replaced picture, so its bytes cannot simply be subtracted.
    const bool replaces = pictures[d] != nullptr;
    pictures[d] = std::move(png);
    if (replaces) count_bytes();
    while (bytes_ > most_bytes_ && frames_.size() > 1) {
        stride_ *= 2;
        for (auto frame = frames_.begin(); frame != frames_.end();) {
            frame = frame->first % stride_ == 0 ? std::next(frame) : frames_.erase(frame);
        }
        count_bytes();
    }
}

void ShownPictures::count_bytes() {
    std::set<const std::string*> seen;
    bytes_ = 0;
    for (const auto& [frame, pictures] : frames_) {
        for (const Png& png : pictures) {
            if (png != nullptr && seen.insert(png.get()).second) bytes_ += png->size();
        }
    }
}

Json ShownPictures::json(PagePictures& pictures) const {
    Json list = Json::array();
    for (const auto& [frame, pngs] : frames_) {
        Json numbers = Json::array();
        for (const Png& png : pngs) numbers.push_back(png == nullptr ? Json() : Json(pictures.add(png)));
        list.push_back({{"frame", frame}, {"pictures", std::move(numbers)}});
    }
    return list;
}

Json Contributions::frame_json(const std::vector<int>& pairs, PagePictures& pictures) {
    Json list = Json::array();
    for (const functional::Contribution& contribution : functional::contributions_of(scenario_, pairs)) {
        if (contribution.image == nullptr) {
            list.push_back(nullptr);
            continue;
        }
        list.push_back({{"image", image_number(*contribution.image, contribution.copy, pictures)},
                        {"table", table_number(contribution.rows)}});
    }
    return list;
}

std::size_t Contributions::image_number(const PixelImage& image, std::shared_ptr<const PixelImage> copy,
                                        PagePictures& pictures) {
    const auto [entry, is_new] = image_numbers_.emplace(&image, images_.size());
    if (!is_new) return entry->second;
    if (copy != nullptr) copies_.push_back(std::move(copy));
    Json json = {{"width", image.width_pixels}, {"height", image.height_pixels}};
    // Once an image does not fit, no other is tried, since encoding takes time.
    if (images_left_out_ == 0) {
        auto colour = std::make_shared<const std::string>(png_of_bits(image, colour_link_bits));
        auto depth = std::make_shared<const std::string>(png_of_bits(
            image, [this](Pixel pixel) { return depth_link_bits(pixel, scenario_.depth_format); }));
        const std::size_t bytes = colour->size() + depth->size();
        if (bytes <= room_) {
            room_ -= bytes;
            json["colour"] = pictures.add(std::move(colour));
            json["depth"] = pictures.add(std::move(depth));
        }
    }
    images_left_out_ += json.contains("colour") ? 0 : 1;
    images_.push_back(std::move(json));
    return entry->second;
}

std::size_t Contributions::table_number(const ViewportTable& rows) {
    Json table = Json::array();
    for (const ViewportRow& row : rows) {
        table.push_back(
            Json::array({row.dcomp, row.sx, row.sy, row.sdx, row.sdy, row.dx, row.dy, row.dmultiple}));
    }
    const auto [entry, is_new] = table_numbers_.emplace(table.dump(), tables_.size());
    if (is_new) tables_.push_back(std::move(table));
    return entry->second;
}

}  // namespace metabuffer::charts
