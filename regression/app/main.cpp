#include "app/commands.h"

int main(int argc, char** argv) { return app::assay_main({argv, argv + argc}); }
