#include "rtl/smoothing_window.h"

#include <algorithm>
#include <string>

namespace metabuffer::rtl {
namespace {

constexpr std::int64_t kNone = Segment::kNoPixel;
constexpr int kWordBits = 64;

}  // namespace

SmoothingWindow::Tap::Tap(RegisterSet& registers, const std::string& name, int pixel_bits)
    : read_pixel(registers, "read_pixel" + name, pixel_bits, kNone),
      stood_pixel(registers, "stood_pixel" + name, pixel_bits, kNone),
      word_pixel(registers, "word_pixel" + name, pixel_bits, kNone),
      bypass_pixel(registers, "bypass_pixel" + name, pixel_bits, kNone),
      bypass_word(registers, "bypass_word" + name, kWordBits) {}

SmoothingWindow::SmoothingWindow(RegisterSet& registers, FifoWires& wires, int pixel_bits) : wires_(wires) {
    for (std::size_t row = 0; row < kRows; ++row) {
        for (std::size_t column = 0; column < kColumns; ++column) {
            const std::string name = "_" + std::to_string(row) + "_" + std::to_string(column);
            taps_[row][column] = std::make_unique<Tap>(registers, name, pixel_bits);
        }
    }
}

/// The pixels that each port must give, in the order of the raster.
std::array<SmoothingWindow::Row, SmoothingWindow::kRows> SmoothingWindow::rows_of(
    const BlendWindow<std::int64_t>& window) {
    const auto row = [](std::int64_t own, std::int64_t beside) {
        return beside == kNone ? Row{own, kNone} : Row{std::min(own, beside), std::max(own, beside)};
    };
    return {row(window.own, window.beside), row(window.across, window.diagonal)};
}

const sc_core::sc_signal<std::uint64_t>& SmoothingWindow::word(std::size_t row, std::size_t column) const {
    const FifoWires::SecondRow& second = *wires_.second_row;
    if (row == 0) return column == 0 ? wires_.word : second.next_word;
    return column == 0 ? second.word : second.row_next_word;
}

BlendWindow<Pixel> SmoothingWindow::pixels(const BlendWindow<std::int64_t>& window) const {
    const std::array<Row, kRows> rows = rows_of(window);
    const auto pixel = [&](std::size_t row, std::int64_t index) {
        const std::size_t column = rows[row][0] == index ? 0 : 1;
        const Tap& tap = *taps_[row][column];
        return Pixel(tap.bypass_pixel == index ? tap.bypass_word.value() : word(row, column).read());
    };
    const Pixel own = pixel(0, window.own);
    const auto or_own = [&](std::size_t row, std::int64_t index) {
        return index == kNone ? own : pixel(row, index);
    };
    return {own, or_own(0, window.beside), or_own(1, window.across), or_own(1, window.diagonal)};
}

void SmoothingWindow::follow_read() {
    for (std::size_t row = 0; row < kRows; ++row) {
        const bool read = port(row).read().enable;
        for (const auto& tap : taps_[row]) {
            tap->stood_pixel = tap->word_pixel;
            if (read) {
                tap->word_pixel = tap->read_pixel;
            }
        }
    }
}

void SmoothingWindow::next(const BlendWindow<std::int64_t>& window, const ComposerBuffer& buffer,
                           const BusBeat& beat, bool kept) {
    const std::array<Row, kRows> rows = rows_of(window);
    for (std::size_t row = 0; row < kRows; ++row) {
        for (std::size_t column = 0; column < kColumns; ++column) {
            const std::int64_t pixel = rows[row][column];
            Tap& tap = *taps_[row][column];
            if (pixel == kNone || tap.has(pixel)) {
                continue;
            }
            if (tap.stood_pixel == pixel) {
                tap.bypass_pixel = pixel;
                tap.bypass_word = word(row, column).read();
                continue;
            }
            const std::int64_t place = pixel - std::int64_t{beat.first};
            if (kept && place >= 0 && place < beat.count && buffer.has_arrived(pixel)) {
                tap.bypass_pixel = pixel;
                tap.bypass_word = beat.words[static_cast<std::size_t>(place)];
            }
        }
    }
}

void SmoothingWindow::read_ahead(const BlendWindow<std::int64_t>* window, const ComposerBuffer& buffer) {
    const std::array<Row, kRows> rows =
        window == nullptr ? std::array<Row, kRows>{Row{kNone, kNone}, Row{kNone, kNone}} : rows_of(*window);
    for (std::size_t row = 0; row < kRows; ++row) {
        const auto lacks = [&](std::size_t column) {
            const std::int64_t pixel = rows[row][column];
            return pixel != kNone && buffer.has_arrived(pixel) && !taps_[row][column]->has(pixel);
        };
        if (!buffer.abandoned() && (lacks(0) || lacks(1))) {
            const std::int64_t first = rows[row][0];
            port(row).write({true, static_cast<std::uint32_t>(buffer.address_of(first))});
            taps_[row][0]->read_pixel = first;
            taps_[row][1]->read_pixel = buffer.has_arrived(first + 1) ? first + 1 : kNone;
        } else if (port(row).read().enable) {
            port(row).write({false, port(row).read().address});
        }
    }
}

void SmoothingWindow::forget() {
    for (const auto& row : taps_) {
        for (const auto& tap : row) {
            tap->word_pixel = kNone;
            tap->bypass_pixel = kNone;
        }
    }
}

void SmoothingWindow::reset() { wires_.second_row->read.write(FifoRead{}); }

}  // namespace metabuffer::rtl
