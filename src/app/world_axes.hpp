#pragma once
#include <filesystem>

namespace ringsplat::app {

/// True when a volume's file tells how it lies in a patient, so that the world's axes mean left, posterior
/// and superior in millimetres (volume/source.hpp).
bool world_is_patient(const std::filesystem::path& volume);

}  // namespace ringsplat::app
