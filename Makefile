# The same commands locally and in CI. They need Python 3.10 to 3.13 with venv, and pip; no ROS.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin

# Nothing here leaves the loopback.
export ROS_AUTOMATIC_DISCOVERY_RANGE = LOCALHOST

# Test processes: one more than there are cores, since the one with the ROS nodes mostly waits.
WORKERS ?= $(shell expr $$(nproc || echo 2) + 1)

.PHONY: demo test quick lint bench fuzz soak docs links figures picture clean

demo: $(VENV)/ros
	@echo 'The closed loop of the paper as ROS nodes: 40 s in real time, then the verdict.'
	@rm -rf build/demo build/demo.html && mkdir -p build
	@$(BIN)/eventreg run exact --bag build/demo --report build/demo.html; code=$$?; \
	echo 'Open build/demo.html to see it.'; exit $$code

test: lint
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup

# What to run between two edits: half a minute of tests on two cores.
quick: lint
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup -m 'not ros and not slow'

lint: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(VENV)/installed
	@for table in $(filter-out bench/soak.py,$(wildcard bench/*.py)); do echo "== $$table"; $(BIN)/python $$table || exit 1; done

# Generated files, texts, bags, models and requests: 20 times as many as in the tests, some 14,000;
# and so of all that hypothesis draws. SEED=N draws others; of the first kind a failure names its
# case, which CASE=N tries alone.
SEED ?= 1
fuzz: $(VENV)/installed
	EVENTREG_FUZZ=20 EVENTREG_FUZZ_SEED=$(SEED) EVENTREG_FUZZ_CASE=$(CASE) \
		$(BIN)/python -m pytest -s test/fuzz
	EVENTREG_FUZZ=20 $(BIN)/python -m pytest -m hypothesis --hypothesis-seed=$(SEED)

# An hour of real time: memory and handles of every node must stay flat.
soak: $(VENV)/installed
	PYTHONPATH=. $(BIN)/python bench/soak.py

# The site: build/docs/index.html. A dead link inside of it is an error.
docs: $(VENV)/docs
	$(BIN)/python -m sphinx -W --keep-going -b html -d build/doctrees docs build/docs
	@echo 'Open build/docs/index.html'

# The links that lead out of it; needs the network.
links: $(VENV)/docs
	$(BIN)/python -m sphinx -q -b linkcheck -d build/doctrees docs build/links

$(VENV)/docs: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	touch $@

# The pictures of docs/gallery.md and docs/delays.md, and the gallery's page; a rerun on one
# machine changes no byte.
figures: $(VENV)/installed
	$(BIN)/eventreg figures --out docs/figures --format svg --page docs/gallery.md
	$(BIN)/eventreg margin exact --plot docs/figures/margin_exact.svg
	$(BIN)/eventreg sweep exact -p controller.k:=0.5..4/60 -p controller.tau:=1/25..1/5/60log \
		--plot docs/figures/sweep_map.svg
	$(BIN)/eventreg sweep exact -p exosystem.tau:=1/25..1/6/200log -p controller.k:=0.5..2/200 \
		--duration 600 --border exosystem.tau,controller.k --plot docs/figures/sweep_border.svg
	$(BIN)/eventreg sweep exact -p links.delay:=0..0.8/17 -p links.loss:=0..0.95/20 \
		--plot docs/figures/sweep_links.svg
	$(BIN)/eventreg sweep exact -p controller.k:=1~10% -p controller.tau:=1/12~10% \
		-p plant.k:=1~10% -p plant.tau:=1/11~10% --sets 20000 --plot docs/figures/sweep_yield.svg

# The picture of README.md: a real run over DDS, the controller switched off and on again.
picture: $(VENV)/installed
	$(BIN)/python docs/demo.py docs/demo.png

$(VENV)/ros: setup.py setup.cfg pyproject.toml
	@echo 'Installing ROS 2 and the package into $(VENV): about 530 MB and some minutes, only this once.'
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --upgrade pip
	@$(BIN)/python -m pip install --editable '.[ros]'
	@touch $@

$(VENV)/installed: $(VENV)/ros
	@echo 'Installing numba and what tests need into $(VENV): about 700 MB more, only this once.'
	@$(BIN)/python -m pip install --editable '.[ros,fast,test]'
	@touch $@

clean:
	rm -rf $(VENV) build install log
