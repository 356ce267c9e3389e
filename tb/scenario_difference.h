#pragma once

#include <sstream>
#include <string>

#include "formats/pixel.h"
#include "scenario/fault_keys.h"
#include "scenario/names.h"
#include "scenario/scenario.h"

namespace metabuffer::test {

/// Notes the first of several comparisons that fails.
class FirstDifference {
  public:
    template <typename Value>
    void compare(const std::string& what, const Value& left, const Value& right) {
        if (left == right || !text_.empty()) return;
        std::ostringstream text;
        text << what << ": " << left << " and " << right;
        text_ = text.str();
    }
    void require(const std::string& what, bool holds) {
        if (!holds && text_.empty()) text_ = what;
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

/// Whether two images give the same memory words once they have come over a link of that format.
inline bool same_pixels(const PixelImage& left, const PixelImage& right, DepthFormat format) {
    if (left.width_pixels != right.width_pixels || left.height_pixels != right.height_pixels) return false;
    for (std::size_t i = 0; i < left.values.size(); ++i) {
        const auto word = [format](Pixel pixel) {
            return with_depth_half(pixel, depth_link_bits(pixel, format), format);
        };
        if (word(left.values[i]) != word(right.values[i])) return false;
    }
    return true;
}

/// What makes two scenarios different machines or different input of one, empty if nothing does. Where in a file
/// a table stands does not count, nor do images that no frame uses.
inline std::string scenario_difference(const Scenario& left, const Scenario& right) {
    FirstDifference first;
    first.compare("name", left.name, right.name);
    first.compare("columns", left.displays.columns, right.displays.columns);
    first.compare("rows", left.displays.rows, right.displays.rows);
    first.compare("width", left.displays.width_pixels, right.displays.width_pixels);
    first.compare("height", left.displays.height_pixels, right.displays.height_pixels);
    first.compare("supersample", left.displays.supersample, right.displays.supersample);
    first.compare("background", left.background_pixel().word(), right.background_pixel().word());
    first.compare("composition", to_string(left.composition), to_string(right.composition));
    first.compare("depth_format", to_string(left.depth_format), to_string(right.depth_format));
    first.compare("near", left.depth_near, right.depth_near);
    first.compare("far", left.depth_far, right.depth_far);
    first.compare("core_mhz", left.clocks.core_mhz, right.clocks.core_mhz);
    first.compare("dvi_in_mhz", left.clocks.dvi_in_mhz, right.clocks.dvi_in_mhz);
    first.compare("dvi_out_mhz", left.clocks.dvi_out_mhz, right.clocks.dvi_out_mhz);
    first.compare("page_words", left.memory.page_words, right.memory.page_words);
    first.compare("page_miss_cycles", left.memory.page_miss_cycles, right.memory.page_miss_cycles);
    first.compare("words_per_cycle", left.memory.words_per_cycle, right.memory.words_per_cycle);
    first.compare("width_bits", left.bus.width_bits, right.bus.width_bits);
    first.compare("burst_pixels", left.bus.burst_pixels, right.bus.burst_pixels);
    first.compare("arbitration", to_string(left.bus.arbitration), to_string(right.bus.arbitration));
    first.compare("buffer_pixels", left.composer.buffer_pixels, right.composer.buffer_pixels);
    first.compare("ready_space_pixels", left.composer.ready_space_pixels, right.composer.ready_space_pixels);
    first.compare("on_starvation", to_string(left.composer.on_starvation),
                  to_string(right.composer.on_starvation));
    first.compare("pacing", to_string(left.pacing), to_string(right.pacing));
    first.compare("link_timeout_pairs", left.link_timeout_pairs, right.link_timeout_pairs);
    first.compare("watchdog_cycles", left.watchdog_cycles, right.watchdog_cycles);
    first.compare("frames", left.frames, right.frames);
    first.compare("renderers", left.renderers.size(), right.renderers.size());
    first.compare("faults", left.faults.size(), right.faults.size());
    if (!first.text().empty()) return first.text();

    for (std::size_t r = 0; r < left.renderers.size(); ++r) {
        const Renderer& one = left.renderers[r];
        const Renderer& other = right.renderers[r];
        const std::string renderer = "renderer " + std::to_string(r);
        first.compare(renderer + " name", one.name, other.name);
        first.compare(renderer + " image width", one.image_width_pixels, other.image_width_pixels);
        first.compare(renderer + " image height", one.image_height_pixels, other.image_height_pixels);
        first.compare(renderer + " frames", one.frames.size(), other.frames.size());
        if (!first.text().empty()) return first.text();
        for (std::size_t f = 0; f < one.frames.size(); ++f) {
            const RendererFrame& frame = one.frames[f];
            const RendererFrame& other_frame = other.frames[f];
            const std::string where = renderer + " frame " + std::to_string(f);
            first.require(where + " table", frame.table == other_frame.table);
            first.compare(where + " viewport", frame.viewport.has_value(), other_frame.viewport.has_value());
            if (frame.viewport && other_frame.viewport) {
                first.compare(where + " x", frame.viewport->x, other_frame.viewport->x);
                first.compare(where + " y", frame.viewport->y, other_frame.viewport->y);
                first.compare(where + " multiple", frame.viewport->multiple, other_frame.viewport->multiple);
            }
            const auto pair = static_cast<std::uint32_t>(f);
            first.require(where + " image",
                          same_pixels(one.image_of_pair(pair), other.image_of_pair(pair), left.depth_format));
        }
    }
    for (std::size_t f = 0; f < left.faults.size(); ++f) {
        const Fault& one = left.faults[f];
        const Fault& other = right.faults[f];
        const std::string fault = "fault " + std::to_string(f);
        first.compare(fault + " renderer", one.renderer, other.renderer);
        first.compare(fault + " kind", to_string(one.kind), to_string(other.kind));
        for (const FaultKey& key : fault_keys()) {
            first.compare(fault + " " + key.name, key.value(one).value_or(-1), key.value(other).value_or(-1));
        }
    }
    return first.text();
}

}  // namespace metabuffer::test
