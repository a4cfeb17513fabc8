#pragma once
#include "ringsplat/base/vector_config.hpp"
