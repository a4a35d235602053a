"""`python -m editor.strings [LANGUAGE]`"""

import sys

from editor.strings.listing import main

if __name__ == "__main__":
    sys.exit(main())
