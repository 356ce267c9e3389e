#pragma once

#include <string>

namespace metabuffer {

/// One line on a terminal that is overwritten as a run goes on, and gone when it ends. Elsewhere it shows
/// nothing.
class ProgressLine {
  public:
    explicit ProgressLine(bool wanted);
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;
    ~ProgressLine();

    void show(const std::string& text) const;

  private:
    bool shown_;
};

}  // namespace metabuffer
