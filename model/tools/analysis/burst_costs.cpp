#include "tools/analysis/burst_costs.h"

#include <algorithm>

namespace metabuffer::analysis {

BurstCosts::BurstCosts(const Segment& segment, int image_width_pixels, const BusConfig& bus,
                       const MemoryConfig& memory, FirstWord first_word, double stretch)
    : segment_(segment),
      image_width_(image_width_pixels),
      burst_pixels_(bus.burst_pixels),
      page_words_(memory.page_words),
      page_miss_cycles_(memory.page_miss_cycles),
      pixels_per_beat_(metabuffer::pixels_per_beat(bus, memory)),
      cycles_per_beat_(metabuffer::cycles_per_beat(bus)),
      grant_cycles_(bus.grant_cycles),
      delay_cycles_(bus_delay_cycles(bus, memory)),
      first_word_(first_word),
      stretch_(stretch) {
    const std::int64_t count = (segment_.pixels() + burst_pixels_ - 1) / burst_pixels_;
    before_.reserve(static_cast<std::size_t>(count) + 1);
    latest_start_.reserve(static_cast<std::size_t>(count));
    before_.push_back(0);
    for (std::int64_t b = 0; b < count; ++b) add_burst(b);
    find_longest();
    find_excess();
}

void BurstCosts::add_burst(std::int64_t b) {
    auto latest = static_cast<double>(segment_.first_use(b * burst_pixels_));
    std::int64_t cycles = 0;
    walk(b, [&](const Piece& piece) {
        // Along a source row the raster needs at most a pixel a clock. So on a bus of a beat a clock, the piece's first
        // pixel has the least time. On a slower bus the last one may have it. Where the raster cuts the first pixel
        // short, the second one is needed sooner than the others. Of a smoothed row several pixels at either end may
        // be needed at once. If the memory stretches a beat beyond its pixels' raster clocks, the last beat's first
        // pixel has the least.
        const auto pass = [&](std::int64_t k) {
            latest = std::min(latest, static_cast<double>(segment_.first_use(k) - delay_cycles_) -
                                          stretch_ * static_cast<double>(cycles_to(k, piece)));
        };
        const std::int64_t edge = segment_.smooths() ? kUnevenPixels : 1;
        for (std::int64_t k = piece.first; k <= std::min(piece.first + edge, piece.last); ++k) pass(k);
        for (std::int64_t k = std::max(piece.first, piece.last - edge + 1); k <= piece.last; ++k) pass(k);
        if (stretch_ > 1.0) {
            pass(std::max(piece.first, piece.last - (piece.last - piece.run_first) % pixels_per_beat_));
        }
        beats_ += (piece.last - piece.run_first) / pixels_per_beat_ -
                  (piece.begins_run ? -1 : (piece.first - 1 - piece.run_first) / pixels_per_beat_);
        page_misses_ += piece.opens_page ? 1 : 0;
        cycles = cycles_to(piece.last, piece);
    });
    before_.push_back(before_.back() + cycles);
    latest_start_.push_back(latest);
}

std::int64_t BurstCosts::address_of(std::int64_t k) const {
    const ViewportRow& row = segment_.row();
    return (row.sy + k / row.sdx) * image_width_ + row.sx + k % row.sdx;
}

/// One past the last pixel that shares source row and page with pixel k.
std::int64_t BurstCosts::piece_end(std::int64_t k) const {
    const std::int64_t address = address_of(k);
    const std::int64_t in_page = page_words_ - address % page_words_;
    const std::int64_t in_row = segment_.row().sdx - k % segment_.row().sdx;
    return k + std::min(in_page, in_row);
}

std::int64_t BurstCosts::pixels_in_page(std::int64_t k) const {
    const std::int64_t page = page_of(k);
    std::int64_t end = piece_end(k);
    while (end < segment_.pixels() && page_of(end) == page) end = piece_end(end);
    return end - k;
}

template <typename Visit>
void BurstCosts::walk(std::int64_t b, Visit visit) const {
    const std::int64_t begin = b * burst_pixels_;
    const std::int64_t end = std::min(begin + burst_pixels_, segment_.pixels());
    std::int64_t open_page = -1;
    if (first_word_ == FirstWord::kHits) open_page = page_of(begin);
    if (first_word_ == FirstWord::kExact && begin > 0) open_page = page_of(begin - 1);
    Piece piece;
    piece.run_first = begin;
    piece.waited = grant_cycles_;
    for (std::int64_t k = begin; k < end; k = piece.last + 1) {
        const std::int64_t page = page_of(k);
        piece.opens_page = page != open_page;
        piece.begins_run = piece.opens_page || k == begin;
        if (piece.opens_page) {
            piece.waited +=
                (k - piece.run_first + pixels_per_beat_ - 1) / pixels_per_beat_ * cycles_per_beat_ +
                page_miss_cycles_;
            piece.run_first = k;
            open_page = page;
        }
        piece.first = k;
        piece.last = std::min(end, piece_end(k)) - 1;
        visit(piece);
    }
}

double BurstCosts::until_pixel(std::int64_t k) const {
    std::int64_t cycles = 0;
    walk(k / burst_pixels_, [&](const Piece& piece) {
        if (piece.first <= k && k <= piece.last) cycles = cycles_to(k, piece);
    });
    return stretch_ * static_cast<double>(cycles);
}

/// The longest burst can begin anywhere, so what counts is the most page changes in any window of a burst's length.
void BurstCosts::find_longest() {
    std::vector<std::int64_t> changes;  // pixels that lie in another page than the one before
    for (std::int64_t k = piece_end(0); k < segment_.pixels(); k = piece_end(k)) {
        if (page_of(k) != page_of(k - 1)) changes.push_back(k);
    }
    std::size_t most = 0;
    for (std::size_t from = 0, to = 0; from < changes.size(); ++from) {
        // A window that begins just before a change has that change and those that follow within its length.
        while (to < changes.size() && changes[to] < changes[from] - 1 + burst_pixels_) ++to;
        most = std::max(most, to - from);
    }
    // Each run of pixels in one page may end with a beat that is not full.
    const auto runs = static_cast<std::int64_t>(most) + 1;
    const std::int64_t pixels = std::min(burst_pixels_, segment_.pixels());
    const std::int64_t most_beats =
        std::min(pixels, (pixels + runs * (pixels_per_beat_ - 1)) / pixels_per_beat_);
    longest_ = stretch_ *
               static_cast<double>(grant_cycles_ + most_beats * cycles_per_beat_ + runs * page_miss_cycles_);
}

void BurstCosts::find_excess() {
    average_ = total() / static_cast<double>(bursts());
    double least = 0.0;
    for (std::size_t b = 0; b < before_.size(); ++b) {
        const double above = stretch_ * static_cast<double>(before_[b]) - average_ * static_cast<double>(b);
        least = std::min(least, above);
        excess_ = std::max(excess_, above - least);
    }
}

}  // namespace metabuffer::analysis
