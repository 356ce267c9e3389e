#include "functional/functional_compositor.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "functional/pixel_runs.h"
#include "scenario/fault_kinds.h"
#include "scenario/link_program.h"

namespace metabuffer::functional {

namespace {

/// A raster is painted in pieces of a row this long: a piece stays in the first level cache until every renderer has
/// been merged into it, so that only the images and the picture pass through memory, each once. The length is a
/// multiple of every supersample.
constexpr int kPiecePixels = 128;

/// A half-open range of raster columns or rows.
struct Range {
    int begin = 0;
    int end = 0;

    bool empty() const { return begin >= end; }
    bool contains(int position) const { return begin <= position && position < end; }
};

/// The raster positions that `count` source pixels from `start` on fill, clipped to 0..size.
Range clipped(int start, int count, int multiple, int size) {
    return {std::max(start, 0), std::min(start + count * multiple, size)};
}

/// For each raster line that an axis of a rectangle shows on, the two source lines that are mixed there.
struct MixedLines {
    std::vector<int> own;
    std::vector<int> other;
    std::vector<std::uint32_t> weight;  ///< of the other one, of 256

    /// Paints each source line's block of raster lines.
    MixedLines(int start, int count, int multiple, const Range& shown) {
        for (int line = 0; line < count; ++line) {
            for (int i = 0; i < multiple; ++i) {
                if (!shown.contains(start + line * multiple + i)) continue;
                const int off_centre = 2 * i + 1 - multiple;
                const int neighbour = line + (off_centre > 0 ? 1 : 0) - (off_centre < 0 ? 1 : 0);
                own.push_back(line);
                other.push_back(std::clamp(neighbour, 0, count - 1));
                weight.push_back(static_cast<std::uint32_t>(256 * std::abs(off_centre) / (2 * multiple)));
            }
        }
    }
};

/// A renderer's rectangle on one display's raster.
class Rectangle {
  public:
    Rectangle(const PixelPlanes& planes, const ViewportRow& row, const Scenario& scenario)
        : planes_(&planes),
          row_(row),
          composition_(scenario.composition),
          far_z_(far_z(scenario.depth_format)),
          columns_(clipped(row.dx, row.sdx, row.dmultiple, scenario.displays.raster_width_pixels())),
          rows_(clipped(row.dy, row.sdy, row.dmultiple, scenario.displays.raster_height_pixels())) {
        if (scenario.composer.smoothing == Smoothing::kBilinear && row.dmultiple > 1) {
            mixed_columns_.emplace(row.dx, row.sdx, row.dmultiple, columns_);
            mixed_rows_.emplace(row.dy, row.sdy, row.dmultiple, rows_);
        }
    }

    /// The raster columns on which it shows.
    const Range& columns() const { return columns_; }
    bool shows_on_row(int y) const { return rows_.contains(y) && !columns_.empty(); }

    /// Its pixels on raster row y, from columns().begin on, valid until another row is asked for.
    SourceRun pixels_on_row(int y) {
        if (mixed_rows_) return mixed_pixels_on_row(static_cast<std::size_t>(y - rows_.begin));
        const int source_row = row_.sy + (y - row_.dy) / row_.dmultiple;
        const int clipped_away = columns_.begin - row_.dx;
        if (row_.dmultiple == 1) {
            const std::size_t first = planes_->index(row_.sx + clipped_away, source_row);
            return {&planes_->argb[first], &planes_->z[first]};
        }
        if (source_row != line_source_row_) lay_out(source_row);
        const int first = clipped_away % row_.dmultiple;
        return {line_argb_.data() + first, line_z_.data() + first};
    }

  private:
    /// Replicates the pixels of a source row that show, wholly or in part. The line then serves every raster row that
    /// the source row fills.
    void lay_out(int source_row) {
        const int multiple = row_.dmultiple;
        const int first = (columns_.begin - row_.dx) / multiple;
        const int end = (columns_.end - 1 - row_.dx) / multiple + 1;
        const auto count = static_cast<std::size_t>(end - first);
        const std::size_t source = planes_->index(row_.sx + first, source_row);
        line_argb_.resize(count * static_cast<std::size_t>(multiple));
        line_z_.resize(line_argb_.size());
        replicate(&planes_->argb[source], count, multiple, line_argb_.data());
        replicate(&planes_->z[source], count, multiple, line_z_.data());
        line_source_row_ = source_row;
    }

    /// The pixels that each raster column's own or other source column has in a source row.
    struct Line {
        std::vector<std::uint32_t> argb;
        std::vector<std::uint32_t> z;

        SourceRun run() const { return {argb.data(), z.data()}; }
    };

    SourceRun mixed_pixels_on_row(std::size_t raster_row) {
        Surroundings around;
        around.own = spread(mixed_rows_->own[raster_row], mixed_columns_->own, own_).run();
        around.beside = spread(mixed_rows_->own[raster_row], mixed_columns_->other, beside_).run();
        around.across = spread(mixed_rows_->other[raster_row], mixed_columns_->own, across_).run();
        around.diagonal = spread(mixed_rows_->other[raster_row], mixed_columns_->other, diagonal_).run();
        around.weight_x = mixed_columns_->weight.data();
        around.weight_y = mixed_rows_->weight[raster_row];
        const std::size_t count = mixed_columns_->own.size();
        line_argb_.resize(count);
        line_z_.resize(count);
        mix(composition_, far_z_, around, count, {line_argb_.data(), line_z_.data()});
        return {line_argb_.data(), line_z_.data()};
    }

    const Line& spread(int line, const std::vector<int>& columns, Line& target) const {
        const std::size_t source = planes_->index(row_.sx, row_.sy + line);
        target.argb.resize(columns.size());
        target.z.resize(columns.size());
        for (std::size_t x = 0; x < columns.size(); ++x) {
            target.argb[x] = planes_->argb[source + static_cast<std::size_t>(columns[x])];
            target.z[x] = planes_->z[source + static_cast<std::size_t>(columns[x])];
        }
        return target;
    }

    const PixelPlanes* planes_;
    ViewportRow row_;
    Composition composition_;
    std::uint32_t far_z_;
    Range columns_;
    Range rows_;
    int line_source_row_ = -1;
    std::vector<std::uint32_t> line_argb_;
    std::vector<std::uint32_t> line_z_;
    std::optional<MixedLines> mixed_columns_;  ///< of a smoothed rectangle
    std::optional<MixedLines> mixed_rows_;
    Line own_;
    Line beside_;
    Line across_;
    Line diagonal_;
};

/// Makes the picture of a raster that comes in pieces, from left to right and from top to bottom.
class PictureBuilder {
  public:
    PictureBuilder(int raster_width, int raster_height, int supersample)
        : raster_width_(static_cast<std::size_t>(raster_width)), supersample_(supersample) {
        picture_.width_pixels = raster_width / supersample;
        picture_.height_pixels = raster_height / supersample;
        // Not resized: setting every pixel to zero first would be one more pass through memory.
        picture_.values.reserve(static_cast<std::size_t>(picture_.width_pixels) *
                                static_cast<std::size_t>(picture_.height_pixels));
        if (supersample > 1) rows_.resize(raster_width_ * static_cast<std::size_t>(supersample));
    }

    /// Takes the colours of at most kPiecePixels pixels from raster column x on; x is a multiple of the supersample.
    void take(int x, int y, const std::uint32_t* argb, std::size_t count) {
        if (supersample_ == 1) {
            append_mean(argb, 0, count);
            return;
        }
        const int row = y % supersample_;
        std::uint32_t* const column = rows_.data() + x;
        std::copy_n(argb, count, column + static_cast<std::size_t>(row) * raster_width_);
        if (row == supersample_ - 1) {
            append_mean(column, raster_width_, count / static_cast<std::size_t>(supersample_));
        }
    }

    ColourImage finish() { return std::move(picture_); }

  private:
    void append_mean(const std::uint32_t* argb, std::size_t stride, std::size_t count) {
        average(argb, stride, supersample_, count, means_.data());
        picture_.values.insert(picture_.values.end(), means_.data(), means_.data() + count);
    }

    std::size_t raster_width_;
    int supersample_;
    std::vector<std::uint32_t> rows_;  ///< the raster rows of one row of the picture
    std::array<std::uint32_t, kPiecePixels> means_{};
    ColourImage picture_;
};

/// Whether the byte that the fault changes belongs to the control scanline's content, and not to the zeros after it.
bool changes_content(const Scenario& scenario, const Fault& fault) {
    const Renderer& renderer = scenario.renderers[static_cast<std::size_t>(fault.renderer)];
    const ControlScanline content = control_content(scenario, renderer, fault.pair, fault.frame);
    return static_cast<std::size_t>(fault.byte) < control_scanline_bytes(content);
}

/// Whether a fault keeps its frame from being accepted.
bool corrupts_frame(const Scenario& scenario, const Fault& fault) {
    switch (fault_traits(fault.kind).effect) {
        case FaultEffect::kNone:
        case FaultEffect::kPixels:
            return false;
        case FaultEffect::kGeometry:
        case FaultEffect::kAbsence:
            return true;
        case FaultEffect::kHeader:
            return fault.kind != FaultKind::kControlByte || changes_content(scenario, fault);
    }
    return false;
}

/// Whether the scenario's faults keep a pair from reaching the back device in time. A link that is silent for some pair
/// times needs one more for the pair itself, and is late only if the sum exceeds the timeout. A colour frame that comes
/// twice takes half a pair time more, which counts if the depth frame is delayed too.
bool is_lost(const Scenario& scenario, int renderer, std::uint32_t pair) {
    const std::optional<std::uint32_t> number =
        scenario.renderers[static_cast<std::size_t>(renderer)].number_of_pair(pair);
    if (!number || (scenario.pacing == Pacing::kLockstep && *number != pair)) return true;
    std::int64_t half_pair_times = 2;
    bool colour_repeated = false;
    bool depth_delayed = false;
    for (const Fault& fault : scenario.faults) {
        if (fault.renderer != renderer || fault.pair != pair) continue;
        if (corrupts_frame(scenario, fault)) return true;
        half_pair_times += 2 * std::int64_t{fault.delay_pairs};
        const bool in_colour = fault.frame == FrameKind::kColour;
        colour_repeated = colour_repeated || (fault.kind == FaultKind::kRepeated && in_colour);
        depth_delayed = depth_delayed || (fault.kind == FaultKind::kDelay && !in_colour);
    }
    half_pair_times += colour_repeated && depth_delayed ? 1 : 0;
    return half_pair_times > 2 * std::int64_t{scenario.link_timeout_pairs};
}

/// The pair's image with the bits that faults flip in its two frames; null if there are none.
std::shared_ptr<const PixelImage> image_with_flipped_bits(const Scenario& scenario, int renderer,
                                                          std::uint32_t pair) {
    std::shared_ptr<PixelImage> copy;
    for (const Fault& fault : scenario.faults) {
        if (fault.kind != FaultKind::kPixelBits || fault.renderer != renderer || fault.pair != pair) continue;
        if (copy == nullptr) {
            const Renderer& source = scenario.renderers[static_cast<std::size_t>(renderer)];
            copy = std::make_shared<PixelImage>(source.image_of_pair(pair));
        }
        Pixel& pixel = copy->at(fault.x, fault.y);
        // In a word R, G, B lie as on the link; A lies above them, and Z in the upper 32 bits.
        std::uint64_t flips = fault.bits;
        if (fault.frame == FrameKind::kDepth) {
            const DepthLayout& layout = layout_of(scenario.depth_format);
            flips = (std::uint64_t{layout.z_of(fault.bits)} << 32) |
                    (std::uint64_t{layout.alpha_of(fault.bits)} << 24);
        }
        pixel = Pixel(pixel.word() ^ flips);
    }
    return copy;
}

}  // namespace

Compositor::Compositor(const Scenario& scenario) : scenario_(scenario) {
    for (const DisplayCorrection& correction : scenario.displays.correction) {
        colour_tables_.emplace(correction.display, correction.table());
    }
}

void Compositor::begin_frame(std::vector<Contribution> contributions) {
    contributions_ = std::move(contributions);
    spare_planes_.clear();
    for (auto known = planes_.begin(); known != planes_.end();) {
        const bool contributed =
            std::any_of(contributions_.begin(), contributions_.end(),
                        [&](const Contribution& each) { return each.image == known->first; });
        if (contributed) {
            ++known;
        } else {
            spare_planes_.push_back(std::move(known->second));
            known = planes_.erase(known);
        }
    }
}

const PixelPlanes& Compositor::planes_of(const PixelImage& image) {
    const auto known = planes_.find(&image);
    if (known != planes_.end()) return known->second;

    PixelPlanes planes;
    if (!spare_planes_.empty()) {
        planes = std::move(spare_planes_.back());
        spare_planes_.pop_back();
    }
    planes.width_pixels = image.width_pixels;
    planes.height_pixels = image.height_pixels;
    planes.argb.resize(image.values.size());
    planes.z.resize(image.values.size());
    take_over_link(image.values.data(), image.values.size(), scenario_.depth_format,
                   {planes.argb.data(), planes.z.data()});
    return planes_.emplace(&image, std::move(planes)).first->second;
}

/// Paints the frame's rectangles over the background, in their order. The raster comes in pieces, from left
/// to right and from top to bottom: take(x, y, pixels, count).
template <typename Take>
void Compositor::paint(int display, const Take& take) {
    std::vector<Rectangle> rectangles;
    for (const Contribution& contribution : contributions_) {
        if (contribution.image == nullptr) continue;
        const auto row =
            std::find_if(contribution.rows.begin(), contribution.rows.end(),
                         [display](const ViewportRow& candidate) { return candidate.dcomp == display; });
        if (row == contribution.rows.end()) continue;
        rectangles.emplace_back(planes_of(*contribution.image), *row, scenario_);
    }

    struct Shown {
        Range columns;
        SourceRun pixels{};  ///< from columns.begin on
    };
    std::vector<Shown> shown;
    struct alignas(64) {
        std::array<std::uint32_t, kPiecePixels> argb{};
        std::array<std::uint32_t, kPiecePixels> z{};
    } piece{};
    const int width = scenario_.displays.raster_width_pixels();
    const int height = scenario_.displays.raster_height_pixels();
    for (int y = 0; y < height; ++y) {
        shown.clear();
        for (Rectangle& rectangle : rectangles) {
            if (rectangle.shows_on_row(y)) shown.push_back({rectangle.columns(), rectangle.pixels_on_row(y)});
        }
        for (int x = 0; x < width; x += kPiecePixels) {
            const int x_end = std::min(x + kPiecePixels, width);
            const auto count = static_cast<std::size_t>(x_end - x);
            fill(scenario_.background_pixel(), count, {piece.argb.data(), piece.z.data()});
            for (const auto& [columns, pixels] : shown) {
                const int begin = std::max(x, columns.begin);
                const int end = std::min(x_end, columns.end);
                if (begin >= end) continue;
                const int from = begin - columns.begin;
                const int to = begin - x;
                merge(scenario_.composition, {pixels.argb + from, pixels.z + from},
                      static_cast<std::size_t>(end - begin), {piece.argb.data() + to, piece.z.data() + to});
            }
            take(x, y, SourceRun{piece.argb.data(), piece.z.data()}, count);
        }
    }
}

PixelImage Compositor::raster(int display) {
    PixelImage raster(scenario_.displays.raster_width_pixels(), scenario_.displays.raster_height_pixels());
    paint(display, [&raster](int x, int y, SourceRun pixels, std::size_t count) {
        join(pixels, count, &raster.at(x, y));
    });
    return raster;
}

ColourImage Compositor::picture(int display) {
    PictureBuilder builder(scenario_.displays.raster_width_pixels(),
                           scenario_.displays.raster_height_pixels(), scenario_.displays.supersample);
    paint(display, [&builder](int x, int y, SourceRun pixels, std::size_t count) {
        builder.take(x, y, pixels.argb, count);
    });
    ColourImage picture = builder.finish();
    correct_colours(display, picture);
    return picture;
}

PixelImage composite_raster(const Scenario& scenario, const std::vector<Contribution>& contributions,
                            int display) {
    Compositor compositor(scenario);
    compositor.begin_frame(contributions);
    return compositor.raster(display);
}

ColourImage average_raster(const PixelImage& raster, int supersample) {
    PictureBuilder builder(raster.width_pixels, raster.height_pixels, supersample);
    std::array<std::uint32_t, kPiecePixels> argb{};
    for (int y = 0; y < raster.height_pixels; ++y) {
        for (int x = 0; x < raster.width_pixels; x += kPiecePixels) {
            const int count = std::min(kPiecePixels, raster.width_pixels - x);
            const Pixel* const first = &raster.at(x, y);
            std::transform(first, first + count, argb.begin(),
                           [](Pixel pixel) { return static_cast<std::uint32_t>(pixel.word()); });
            builder.take(x, y, argb.data(), static_cast<std::size_t>(count));
        }
    }
    return builder.finish();
}

// Not by the levels' own lookup: each channel is taken out, looked up and put back on its own.
void Compositor::correct_colours(int display, ColourImage& picture) const {
    const auto table = colour_tables_.find(display);
    if (table == colour_tables_.end()) return;
    constexpr int kChannelBits = 8;
    int shift = 0;
    for (std::size_t c = ColourTable::kChannels; c-- > 0; shift += kChannelBits) {
        std::array<std::uint32_t, ColourTable::kValues> in_place{};
        for (std::size_t v = 0; v < in_place.size(); ++v) {
            in_place[v] = std::uint32_t{table->second.channels()[c][v]} << shift;
        }
        const std::uint32_t mask = std::uint32_t{0xFF} << shift;
        for (std::uint32_t& colour : picture.values) {
            colour = (colour & ~mask) | in_place[(colour & mask) >> shift];
        }
    }
}

ColourImage composite_display(const Scenario& scenario, const std::vector<Contribution>& contributions,
                              int display) {
    Compositor compositor(scenario);
    compositor.begin_frame(contributions);
    return compositor.picture(display);
}

// With free-running pacing, time decides which pair a frame shows. There is no time here, so the same rule is used
// instead. The clocked model's report says which pairs were shown (FrameRecord::pairs); contributions_of accepts those
// as well as the ones made here.
bool take_pairs_without_time(const Scenario& scenario, int frame, std::vector<int>& pairs) {
    const auto pair = static_cast<std::uint32_t>(frame);
    pairs.resize(scenario.renderers.size(), -1);
    for (std::size_t r = 0; r < pairs.size(); ++r) {
        const Renderer& renderer = scenario.renderers[r];
        const int index = static_cast<int>(r);
        // Without time a link is silent until its pair is lost.
        while (renderer.is_live && scenario.live_pairs->next(index, pair) == LivePairs::Next::kSilence &&
               !is_lost(scenario, index, pair)) {
        }
        if (frame >= scenario.frames) return false;
        if (!is_lost(scenario, index, pair)) pairs[r] = static_cast<int>(*renderer.number_of_pair(pair));
    }
    return true;
}

std::vector<std::vector<int>> pairs_without_time(const Scenario& scenario) {
    std::vector<int> pairs;
    std::vector<std::vector<int>> result;
    for (int frame = 0; take_pairs_without_time(scenario, frame, pairs); ++frame) result.push_back(pairs);
    return result;
}

std::vector<Contribution> contributions_of(const Scenario& scenario, const std::vector<int>& pairs) {
    std::vector<Contribution> contributions(scenario.renderers.size());
    for (std::size_t index = 0; index < contributions.size(); ++index) {
        if (pairs.at(index) < 0) continue;
        const Renderer& renderer = scenario.renderers[index];
        const std::uint32_t pair = renderer.pair_of_number(static_cast<std::uint32_t>(pairs[index]));
        Contribution& contribution = contributions[index];
        contribution.copy = image_with_flipped_bits(scenario, static_cast<int>(index), pair);
        contribution.image =
            contribution.copy != nullptr ? contribution.copy.get() : &renderer.image_of_pair(pair);
        contribution.rows =
            validate_table(renderer.frame_of_pair(pair).table, scenario.limits(renderer)).rows;
    }
    return contributions;
}

}  // namespace metabuffer::functional
