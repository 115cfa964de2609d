#pragma once

#include "veridyn/regressor/base_parameters.hpp"
