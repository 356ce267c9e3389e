#pragma once

#include <filesystem>

namespace metabuffer {

/// A folder of this object alone, where temporary files lie. It goes with the object, and what is in it.
class TemporaryFolder {
  public:
    /// Throws std::system_error if none can be made.
    TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder();

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace metabuffer
