// One parameter of the page: a slider and a number field that show the same value, its unit and range, and what is
// wrong with what was entered. At most one change is on its way to the server; the latest one follows when it is answered.
export default {
  props: {
    label: String, symbol: String, unit: String, allowed: String, name: String,
    shown: String, // as it stands in the field
    at: Number, // place of the slider, 0 to 1
    low: Number, high: Number, log: Boolean, whole: Boolean, optional: Boolean,
    hint: String, // what holds while an optional field is empty
    error: String,
    answered: Number, // number of the last change that the server has dealt with
  },
  emits: ["change"],
  template: `
    <div class="field" :class="{ wrong: error }">
      <label :for="id">{{ label }} <i>{{ symbol }}</i></label>
      <input type="range" min="0" max="1" step="any" :value="slider" :aria-label="label"
        :aria-valuetext="text + ' ' + (unit || '')" :data-field="name" @input="slide" @keydown="step"
        @pointerdown="held = true" @pointerup="held = false" @pointercancel="held = false" @blur="held = false" />
      <input ref="number" type="text" inputmode="decimal" autocomplete="off" spellcheck="false" :id="id" :value="text"
        :placeholder="hint" :aria-label="label + (unit ? ' in ' + unit : '')" :aria-invalid="!!error" :aria-describedby="id + 'r'"
        :data-number="name" @focus="begin" @input="entry = $event.target.value" @change="enter"
        @keydown.enter="enter" @blur="leave" />
      <span class="unit">{{ unit }}</span>
      <small class="range" :id="id + 'r'">{{ allowed }}</small>
      <p class="error" role="alert" v-if="error">{{ error }}</p>
    </div>`,
  data() {
    return {
      id: "field-" + this.name, held: false, typing: false, entry: null, here: null, sent: 0, waiting: null,
      asked: null, // text that was entered and is not answered yet
    };
  },
  computed: {
    slider() {
      return this.held && this.here != null ? this.here : this.at;
    },
    text() {
      return this.entry != null && (this.typing || this.error) ? this.entry : this.shown;
    },
  },
  watch: {
    answered(now) {
      if (now < this.sent) return;
      if (this.waiting != null) return this.send(this.waiting);
      // what was taken stands there as a value, unless more has been typed since
      if (!this.error && this.entry === this.asked) this.settle();
      this.asked = null;
    },
    shown() {
      if (!this.typing) this.entry = null;
    },
    error(now) {
      if (!now && !this.typing) this.entry = null;
    },
  },
  methods: {
    value(at) {
      const { low, high } = this;
      const value = this.log ? low * Math.pow(high / low, at) : low + (high - low) * at;
      return this.whole ? String(Math.round(value)) : Number(value.toPrecision(4)).toString();
    },
    slide(event) {
      this.here = Number(event.target.value);
      this.entry = null;
      this.offer(this.value(this.here));
    },
    // a hundredth of the range by arrow keys, a tenth by page keys; a whole number by one
    step(event) {
      const keys = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
      if (!(event.key in keys)) return;
      event.preventDefault();
      const one = this.whole ? 1 / (this.high - this.low) : 0.01;
      const at = Number(event.target.value) + one * keys[event.key];
      event.target.value = Math.min(1, Math.max(0, at));
      this.slide(event);
    },
    begin(event) {
      this.typing = true;
      event.target.select();
    },
    // Enter comes twice, as a key and as a change
    enter(event) {
      const text = event.target.value;
      if (text === this.asked || (text === this.shown && !this.error)) return;
      this.entry = this.asked = text;
      this.offer(text);
    },
    leave() {
      this.typing = false;
      if (!this.error && this.entry === this.shown) this.entry = null;
    },
    // show the value in place of what was typed, ready to be typed over
    settle() {
      this.entry = null;
      this.$nextTick(() => {
        if (this.typing) this.$refs.number.select();
      });
    },
    offer(text) {
      if (this.sent > (this.answered || 0)) this.waiting = text;
      else this.send(text);
    },
    send(text) {
      this.waiting = null;
      this.sent = Math.max(this.sent, this.answered || 0) + 1;
      this.$emit("change", { text, number: this.sent });
    },
  },
};
