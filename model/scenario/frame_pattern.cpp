#include "scenario/frame_pattern.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <iterator>

#include "host/text.h"

namespace metabuffer::input {
namespace {

std::optional<int> frame_number(const std::string& text) {
    int number = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || stop != end || number < 0) return std::nullopt;
    return number;
}

/// Between `from` at frame 0 and `to` at frame `frames`; rounded to nearest, a half away from zero.
int between(int from, int to, int frame, int frames) {
    const std::int64_t way = (std::int64_t{to} - from) * frame;
    const std::int64_t half = (way < 0 ? -frames : frames) / 2;
    return static_cast<int>(from + (way + half) / frames);
}

}  // namespace

std::optional<FrameNumbers> parse_frame_numbers(const std::string& text) {
    const std::size_t dash = text.find('-');
    const std::optional<int> first = frame_number(text.substr(0, dash));
    const std::optional<int> last = dash == std::string::npos ? first : frame_number(text.substr(dash + 1));
    if (!first || !last || *first > *last) return std::nullopt;
    return FrameNumbers{*first, *last};
}

std::optional<std::string> numbered_name(const std::string& name, int number) {
    const std::size_t percent = name.find('%');
    if (percent == std::string::npos) return name;
    std::size_t at = percent + 1;
    std::size_t digits = 0;
    if (at + 1 < name.size() && name[at] == '0' && text::is_digit(name[at + 1])) {
        digits = static_cast<std::size_t>(name[at + 1] - '0');
        at += 2;
    }
    if (at >= name.size() || name[at] != 'd' || name.find('%', at) != std::string::npos) return std::nullopt;
    const std::string written = std::to_string(number);
    const std::string zeros(digits - std::min(digits, written.size()), '0');
    return name.substr(0, percent) + zeros + written + name.substr(at + 1);
}

Viewport viewport_on_path(const std::vector<PathPosition>& path, int frame) {
    const auto after =
        std::upper_bound(path.begin(), path.end(), frame,
                         [](int number, const PathPosition& position) { return number < position.frame; });
    if (after == path.begin()) return path.front().viewport;
    const PathPosition& before = *std::prev(after);
    Viewport viewport = before.viewport;
    if (after == path.end()) return viewport;
    const int frames = after->frame - before.frame;
    viewport.x = between(before.viewport.x, after->viewport.x, frame - before.frame, frames);
    viewport.y = between(before.viewport.y, after->viewport.y, frame - before.frame, frames);
    return viewport;
}

}  // namespace metabuffer::input
