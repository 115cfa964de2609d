#include "question.hpp"
namespace veridyn {
void add_rivals(const Model&, const ExcitationOptions&, double, Question&) {}
}
