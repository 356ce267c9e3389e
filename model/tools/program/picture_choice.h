#pragma once

#include <string>

namespace metabuffer {

/// Which pictures a run writes.
struct PictureChoice {
    int first_frame = 0;
    int last_frame = 0;
    bool each_frame = true;  ///< a file for each frame and display, besides those of the last frame
    bool none = false;

    bool holds(int frame) const { return !none && first_frame <= frame && frame <= last_frame; }
};

/// `text`: "all", "last", "none", a frame "2" or frames "2-5". `frames`: the number of the scenario's frames, which are
/// counted from 0. Throws InputError, which begins with the option.
PictureChoice parse_picture_choice(const std::string& option, const std::string& text, int frames);

/// Whether the text names no picture. This can be answered without a scenario.
bool names_no_picture(const std::string& text);

}  // namespace metabuffer
