#pragma once

#include <memory>
#include <string>

#include "formats/image.h"

namespace metabuffer {

/// A window with the wall in it, by SDL2, which is loaded when it is needed. Keys: W shows which pixels are wrong, Q and
/// Escape close it.
class WallWindow {
  public:
    /// Null, and why_not says why in a clause, if there can be no window.
    static std::unique_ptr<WallWindow> open(const std::string& title, std::string& why_not);

    WallWindow() = default;
    WallWindow(const WallWindow&) = delete;
    WallWindow& operator=(const WallWindow&) = delete;
    virtual ~WallWindow() = default;

    /// marked: the same picture with the wrong pixels marked. state: what the title says of it.
    virtual void show(const ColourImage& picture, const ColourImage& marked, const std::string& state) = 0;
    /// Answers the user's keys and the window's changes. False once the user has closed it.
    virtual bool poll() = 0;
};

}  // namespace metabuffer
