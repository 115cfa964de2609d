#pragma once

#include "veridyn/regressor/standard_parameters.hpp"
