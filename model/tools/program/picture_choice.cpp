#include "tools/program/picture_choice.h"

#include <charconv>
#include <optional>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer {
namespace {

constexpr const char* kAll = "all";
constexpr const char* kLast = "last";
constexpr const char* kNone = "none";

std::optional<int> frame_number(const std::string& text) {
    int frame = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, frame);
    if (error != std::errc() || stop != end || frame < 0) return std::nullopt;
    return frame;
}

}  // namespace

bool names_no_picture(const std::string& text) { return text == kNone; }

PictureChoice parse_picture_choice(const std::string& option, const std::string& text, int frames) {
    PictureChoice choice;
    choice.last_frame = frames - 1;
    if (text == kAll) return choice;
    if (text == kLast) {
        choice.each_frame = false;
        return choice;
    }
    if (names_no_picture(text)) {
        choice.none = true;
        return choice;
    }
    const std::size_t dash = text.find('-');
    const std::optional<int> first = frame_number(text.substr(0, dash));
    const std::optional<int> last = dash == std::string::npos ? first : frame_number(text.substr(dash + 1));
    if (!first || !last || *first > *last) {
        throw InputError(option + " " + text::quoted(text) +
                         ": use all, last, none, a frame such as 2, or frames such as 2-5");
    }
    if (*last >= frames) {
        throw InputError(option + " " + text::quoted(text) + ": the scenario has " +
                         text::counted(frames, "frame") + ", counted from 0; name frames up to " +
                         std::to_string(frames - 1));
    }
    choice.first_frame = *first;
    choice.last_frame = *last;
    return choice;
}

}  // namespace metabuffer
